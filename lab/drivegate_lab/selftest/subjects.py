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
from drivegate_lab.candidates.families import DESIGN_NAMES, SENSORLESS_DESIGN_NAMES
from drivegate_lab.candidates.faults.catalogue import MUTATIONS, find_fault
from drivegate_lab.candidates.faults.seeded_fault import SeededFault
from drivegate_lab.candidates.faults.tolerances import NEAR_DESIGNS
from drivegate_lab.candidates.field_faults import FIELD_FAULTS
from drivegate_lab.candidates.sensorless_faults import SENSORLESS_FAULTS

SENSORLESS: Final = "foc-sensorless"
"""The controller that needs no position sensor."""
_NOT_EVERYWHERE: Final = ("foc-mtpa", SENSORLESS)
FAULTS_OF: Final[Mapping[str, Mapping[str, SeededFault]]] = {
    "current": MUTATIONS,
    "duty": {**DUTY_FAULTS, **FIELD_FAULTS, **SENSORLESS_FAULTS},
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


def correct_designs(contract: str = "current", *, sensed: bool = True) -> tuple[CorrectDesign, ...]:
    """List the controllers of a contract that must pass, on drives with a position sensor or without.

    The published search fails what its lock-up fails, but follows its own flowchart. Of the field-oriented ones, the
    one without weakening gives less torque above base speed than there is.
    """
    return _CORRECT[contract] if sensed else _UNSENSED


_CORRECT: Final = {
    "current": (
        CorrectDesign("reference"),
        *(CorrectDesign(f"{DESIGN_PREFIX}{name}") for name in DESIGN_NAMES),
        *(CorrectDesign(NEAR_PREFIX + name, near=True) for name in NEAR_DESIGNS),
        CorrectDesign("published", frozenset({"FLO-1"})),
    ),
    "duty": tuple(CorrectDesign(name) for name in DUTY_CANDIDATES if name not in _NOT_EVERYWHERE),
}
_UNSENSED: Final = tuple(
    CorrectDesign(name)
    for name in (SENSORLESS, *(f"{DESIGN_PREFIX}{name}" for name in SENSORLESS_DESIGN_NAMES))
)


def chosen_faults(names: Sequence[str], drive: DriveDocument) -> tuple[SeededFault, ...]:
    """Find faulty controllers of a drive's contract by their names; without any, all of them.

    On a drive without a position sensor these are others than on one with a sensor.
    """
    known = FAULTS_OF[drive.contract]
    unsensed = drive.position == "none"
    every = [name for name, fault in known.items() if (fault.base == SENSORLESS) is unsensed]
    chosen = list(dict.fromkeys(name.removeprefix(FAULTY_PREFIX) for name in names)) or every
    for name in chosen:
        if any(name in faults for faults in FAULTS_OF.values()):
            require_contract(resolve_candidate(FAULTY_PREFIX + name), drive)
    return tuple(find_fault(name, known) for name in chosen)
