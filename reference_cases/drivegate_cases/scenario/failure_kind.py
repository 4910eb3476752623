"""The kinds of failures during a run; listing them needs no reader of documents."""

from typing import Final, Literal, TypeAlias, get_args

FailureKind: TypeAlias = Literal[
    "open-phase", "stuck-current", "lost-position", "locked-rotor", "lost-edge", "slip"
]
"""A leg whose switches both stay off, a current sensor or the shaft's position that stays, a shaft that stands, one
edge of the position that does not come, or a magnet of the position's sensor that turns on the shaft."""
FAILURE_KINDS: Final[tuple[FailureKind, ...]] = get_args(FailureKind)
