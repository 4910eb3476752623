"""What can fail during a run of a PM AC drive."""

from typing import Final, Literal, TypeAlias, get_args

FailureKind: TypeAlias = Literal["open-phase", "stuck-current", "lost-position", "locked-rotor", "lost-edge"]
"""A leg whose switches both stay off, a current sensor or the shaft's position that stays, a shaft that stands, or one
edge of the position that does not come."""
FAILURE_KINDS: Final[tuple[FailureKind, ...]] = get_args(FailureKind)
"""All of them."""
PHASED: Final[frozenset[FailureKind]] = frozenset({"open-phase", "stuck-current"})
"""Those of one phase."""
SURVIVABLE: Final[frozenset[FailureKind]] = frozenset({"lost-edge"})
"""Those behind which a drive may also go on."""
