"""The controllers of the self-test: faulty ones with their check, and correct ones that no check may accuse."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final

from drivegate.candidates.builtin.candidates import DUTY_CANDIDATES
from drivegate.candidates.kinds import DESIGN_PREFIX, FAULTY_PREFIX, NEAR_PREFIX
from drivegate.candidates.resolution import resolve_candidate
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.duty.document import duty_document
from drivegate.drives.kinds import require_contract
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_lab.candidates.duty_faults import DUTY_FAULTS, DutyFault
from drivegate_lab.candidates.families import DESIGN_NAMES
from drivegate_lab.candidates.faults.catalogue import MUTATIONS, find_fault
from drivegate_lab.candidates.faults.mutation import Mutation, idle_on, text_on
from drivegate_lab.candidates.faults.tolerances import NEAR_DESIGNS
from drivegate_models.contract.duty.signals import DutyNameplate

_WITHOUT_WEAKENING: Final = "foc-mtpa"
FAULTS_OF: Final[Mapping[str, Mapping[str, Mutation | DutyFault]]] = {
    "current": MUTATIONS,
    "duty": DUTY_FAULTS,
}
"""The faulty controllers of each contract, by their names."""
_TRUE_HERE: Final = "the wrong value that the controller gets is right for this drive"


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


@dataclass(frozen=True)
class FaultOnDrive:
    """What a fault is on one drive."""

    sentence: str
    """What is wrong with the controller, with the drive's numbers."""
    shown_by: str
    """What a scenario must have to show it; empty where loaded steady runs do."""
    idle_because: str | None
    """Why it does nothing on the drive; None where it does something."""


@dataclass(frozen=True)
class SeededFault:
    """A built-in controller with one known fault."""

    name: str
    """Its name; as a candidate it is named ``faulty:`` and this."""
    kind: str
    """What kind of fault it is; the self-test counts by kind."""
    check: str
    """Identifier of the check that must catch it on the drive."""
    base: str
    """Name of the controller without the fault."""
    on: Callable[[DriveDocument], FaultOnDrive]
    """From a drive to what the fault is there; some need the compiled oracle for it."""


def chosen_faults(names: Sequence[str], drive: DriveDocument) -> tuple[SeededFault, ...]:
    """Find faulty controllers of a drive's contract by their names; without any, all of them."""
    known: Mapping[str, Mutation | DutyFault] = FAULTS_OF[drive.contract]
    chosen = dict.fromkeys(name.removeprefix(FAULTY_PREFIX) for name in names) or known
    for name in chosen:
        if any(name in faults for faults in FAULTS_OF.values()):
            require_contract(resolve_candidate(FAULTY_PREFIX + name), drive)
    return tuple(seeded(name, find_fault(name, known), drive) for name in chosen)


def seeded(name: str, fault: Mutation | DutyFault, drive: DriveDocument) -> SeededFault:
    """Return a faulty controller as the self-test has it on a drive of its contract."""
    if isinstance(fault, Mutation):
        return SeededFault(name, fault.kind, fault.check, fault.base, partial(_mutation_on, fault))
    on_drive = partial(_duty_fault_on, fault)
    return SeededFault(
        name, fault.kind, fault.check_on(_nameplate(drive)), contract_of(drive).usual_candidate, on_drive
    )


def _mutation_on(mutation: Mutation, drive: DriveDocument) -> FaultOnDrive:
    sentence, shown_by = (text_on(mutation, text, drive) for text in (mutation.sentence, mutation.shown_by))
    return FaultOnDrive(sentence, shown_by, idle_on(mutation, drive))


def _duty_fault_on(fault: DutyFault, drive: DriveDocument) -> FaultOnDrive:
    plate = _nameplate(drive)
    check = next(check for check in contract_of(drive).checks if check.id == fault.check_on(plate))
    usual = resolve_candidate(contract_of(drive).usual_candidate)
    reason = check.reason_not_applicable(usual.declaration, drive)
    return FaultOnDrive(fault.sentence, "", _TRUE_HERE if fault.idles_on(plate) else reason)


def _nameplate(drive: DriveDocument) -> DutyNameplate:
    document = duty_document(drive)
    return document.duty_nameplate(document.control_period_s, torque_reference=True)
