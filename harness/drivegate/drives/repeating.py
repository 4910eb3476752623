"""A scenario repeated in the process that has run it before: on the same instance, and on a new one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

from numpy.typing import NDArray

from drivegate.checks.record import Record
from drivegate.containment.messages import AnyController, JudgedCandidate
from drivegate.contracts.parting import SEED_IN_RESET, Parting, parting_of, room_for_commands
from drivegate.drives.running import recorded

_OUTSIDE: Final = (
    f"something outside of the instance is kept, or the answer goes by chance or a clock; {SEED_IN_RESET}"
)


def with_repetitions(
    loaded: JudgedCandidate, record: Record, kept: NDArray[Any], controller: AnyController
) -> Record:
    """Repeat a finished run whose commands were kept, and tell where the repetitions part from it."""
    digests, partings = [], []
    # A new instance takes the place of the one before, so it is made after that has run.
    for new in (False, True):
        room = room_for_commands(record.scenario)
        instance = loaded.controller() if new else controller
        digests.append(recorded(loaded, record.scenario, instance, kept=room).run.digest)
        partings.append(parting_of(record.scenario, room, kept))
    return replace(record, repeated_digests=tuple(digests), parting=_in_words(partings))


def _in_words(partings: Sequence[Parting | None]) -> str:
    same, new = partings
    if same is None:
        return "" if new is None else f"the run on a new instance {new}; {_OUTSIDE}"
    cause = "reset kept something" if new is None else f"so does that on a new instance: {_OUTSIDE}"
    return f"the second run on the same instance {same}; {cause}"
