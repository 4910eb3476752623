"""The controllers of the self-test: faulty ones with their check, and correct ones that no check may accuse."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from drivegate.candidates.builtin.candidates import DUTY_CANDIDATES
from drivegate.candidates.kinds import DESIGN_PREFIX, FAULTY_PREFIX, NEAR_PREFIX
from drivegate.candidates.resolution import resolve_candidate
from drivegate.drives.kinds import require_contract
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_lab.candidates.duty_faults import DUTY_FAULTS
from drivegate_lab.candidates.families import DESIGN_NAMES
from drivegate_lab.candidates.faults.catalogue import MUTATIONS, find_fault
from drivegate_lab.candidates.faults.seeded_fault import SeededFault
from drivegate_lab.candidates.faults.tolerances import NEAR_DESIGNS
from drivegate_lab.candidates.field_faults import FIELD_FAULTS

_WITHOUT_WEAKENING: Final = "foc-mtpa"
FAULTS_OF: Final[Mapping[str, Mapping[str, SeededFault]]] = {
    "current": MUTATIONS,
    "duty": {**DUTY_FAULTS, **FIELD_FAULTS},
}
"""The faulty controllers of each contract, by their names."""


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
        *(CorrectDesign(f"{DESIGN_PREFIX}{name}") for name in DESIGN_NAMES),
        *(CorrectDesign(NEAR_PREFIX + name, near=True) for name in NEAR_DESIGNS),
        CorrectDesign("published", frozenset({"FLO-1"})),
    ),
    "duty": tuple(CorrectDesign(name) for name in DUTY_CANDIDATES if name != _WITHOUT_WEAKENING),
}


def chosen_faults(names: Sequence[str], drive: DriveDocument) -> tuple[SeededFault, ...]:
    """Find faulty controllers of a drive's contract by their names; without any, all of them."""
    known = FAULTS_OF[drive.contract]
    chosen = dict.fromkeys(name.removeprefix(FAULTY_PREFIX) for name in names) or known
    for name in chosen:
        if any(name in faults for faults in FAULTS_OF.values()):
            require_contract(resolve_candidate(FAULTY_PREFIX + name), drive)
    return tuple(find_fault(name, known) for name in chosen)
