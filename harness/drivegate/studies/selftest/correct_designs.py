"""Controllers that are right, of whatever design: no check may accuse one of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from drivegate.candidates.builtin.candidates import DESIGN_CANDIDATES, DUTY_CANDIDATES
from drivegate.candidates.builtin.near import NEAR_DESIGNS
from drivegate.candidates.kinds import NEAR_PREFIX

_WITHOUT_WEAKENING: Final = "foc-mtpa"


@dataclass(frozen=True)
class CorrectDesign:
    """A controller that must pass."""

    candidate: str
    """The string that names it."""
    checks: frozenset[str] | None = None
    """Identifiers of the checks that it must pass; None for all of them."""
    near: bool = False
    """Whether it is near a limit by design."""


def correct_designs(contract: str = "current") -> tuple[CorrectDesign, ...]:
    """List the controllers of a contract that must pass.

    The published search fails what its lock-up fails, but follows its own flowchart. Of the field-oriented ones, the
    one without weakening gives less torque above base speed than there is.
    """
    return _CORRECT[contract]


_CORRECT: Final = {
    "current": (
        CorrectDesign("reference"),
        *(CorrectDesign(name) for name in DESIGN_CANDIDATES),
        *(CorrectDesign(NEAR_PREFIX + name, near=True) for name in NEAR_DESIGNS),
        CorrectDesign("published", frozenset({"FLO-1"})),
    ),
    "duty": tuple(CorrectDesign(name) for name in DUTY_CANDIDATES if name != _WITHOUT_WEAKENING),
}
