"""All kinds of drives, each a plant with the name of its contract, and which of them a drive belongs to."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Final

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.contract import ANSWERS
from drivegate.candidates.contract_keys import refuse_other_keys
from drivegate_cases.documents.wording import one_line
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate_cases.drive.drive_document import DriveDocument
    from drivegate_cases.scenario.scenario import Scenario


class DriveKind(ABC):
    """A kind of drive; it imports no compiled code until its loop is prepared."""

    name: ClassVar[str]
    contract: ClassVar[str]
    default_drive: ClassVar[str]
    """Name of the packaged drive that stands for this kind."""
    compiling_s: ClassVar[int]
    """Time to compile its kernels on 2 processors, as measured (s)."""
    has_angles: ClassVar[bool]
    """Whether its controllers answer with an advance angle, over which `drivegate_models.steady` studies the drive."""

    @abstractmethod
    def prepare_loop(self) -> Callable[..., Any]:
        """Return the function that prepares a run of a controller against the plant."""


class _HalfBridge(DriveKind):
    """The phase-decoupled machine on half-bridge legs at a split supply: the drive of the paper."""

    name = "half-bridge"
    contract = "current"
    default_drive = "paper-5-phase"
    compiling_s = 20
    has_angles = True

    def prepare_loop(self) -> Callable[..., Any]:
        from drivegate_models.half_bridge.closed_loop import prepared_loop

        return prepared_loop


class _Star(DriveKind):
    """The star-connected machine with an isolated neutral: conventional brushless DC drives."""

    name = "star"
    contract = "current"
    default_drive = "star-3-phase"
    compiling_s = 20
    has_angles = True

    def prepare_loop(self) -> Callable[..., Any]:
        from drivegate_models.star.closed_loop import prepared_loop

        return prepared_loop


class _PmAc(DriveKind):
    """The d-q machine on a two-level bridge: three sinusoidal phases, as most brushless drives have them."""

    name = "pm-ac"
    contract = "duty"
    default_drive = "pm-ac-interior"
    compiling_s = 25
    has_angles = False

    def prepare_loop(self) -> Callable[..., Any]:
        from drivegate_models.pm_ac.closed_loop import prepared_duty_loop

        return prepared_duty_loop


HALF_BRIDGE: Final = _HalfBridge()
STAR: Final = _Star()
PM_AC: Final = _PmAc()
DRIVE_KINDS: Final[Mapping[str, DriveKind]] = {kind.name: kind for kind in (HALF_BRIDGE, STAR, PM_AC)}
"""Every kind by its name, which is the `kind` of its documents."""
DEFAULT_KIND: Final = HALF_BRIDGE
"""The kind that controllers are made for by default."""
DEFAULT_DRIVE: Final = DEFAULT_KIND.default_drive
DEFAULT_DRIVES: Final[Mapping[str, str]] = {"current": DEFAULT_DRIVE, "duty": PM_AC.default_drive}
"""Name of the drive that a candidate of each contract is judged on by default."""


def kind_of(drive: DriveDocument) -> DriveKind:
    return DRIVE_KINDS[drive.kind]


def drive_for(candidate: Candidate | None, named: DriveDocument | None = None) -> DriveDocument:
    """Choose the drive of a candidate; what a user names wins over its manifest."""
    from drivegate_cases.drive.drive_document import load_drive

    own = None if candidate is None else candidate.drive
    contract = None if candidate is None else candidate.contract
    drive = named or own or load_drive(DEFAULT_DRIVES[contract or "current"])
    if candidate is None:
        return drive
    require_contract(candidate, drive)
    return at_declared_timing(drive, [candidate])


def at_declared_timing(drive: DriveDocument, candidates: Iterable[Candidate]) -> DriveDocument:
    """Return a drive with the control period and the delay that candidates declare; the others run at any."""
    compared = list(candidates)
    changes: dict[str, int] = {}
    for key in ("control_every", "update_delay"):
        declared = {getattr(candidate.declaration, key): candidate.name for candidate in compared}
        declared.pop(None, None)
        if not declared or key not in drive.table_of_key():
            continue
        (changes[key], first), *others = declared.items()
        for other, name in others:
            raise InputError(
                f"the manifest of '{one_line(first)}' has {key} = {changes[key]} and that of '{one_line(name)}' "
                f"{other}, but candidates are compared at one; compare those of the same {key}"
            )
    if not changes:
        return drive
    try:
        return drive.replaced(**changes)
    except InputError as error:
        # The beginning names the class of the document.
        reason = str(error).partition(": ")[2]
        raise InputError(
            f"the drive '{drive.name}' cannot have what the manifest states: {reason}"
        ) from error


def scenario_at_declared_timing(scenario: Scenario, candidates: Iterable[Candidate]) -> Scenario:
    """Return a scenario whose drive has the control period and the delay that candidates declare."""
    drive = at_declared_timing(scenario.drive, candidates)
    return scenario if drive is scenario.drive else scenario.replaced(drive=drive)


def require_contract(candidate: Candidate, drive: DriveDocument) -> None:
    """Refuse a candidate of one contract on a drive of another, and what its manifest states for another."""
    if candidate.contract is None:
        refuse_other_keys(
            candidate.declaration, drive.contract, f"the candidate '{one_line(candidate.name)}': "
        )
    if candidate.contract in (None, drive.contract):
        return
    raise InputError(
        f"the candidate '{one_line(candidate.name)}' answers with {ANSWERS[candidate.contract]}, but the drive "
        f"'{one_line(drive.name)}' of the kind '{drive.kind}' takes {ANSWERS[drive.contract]}; name a drive such as "
        f"{DEFAULT_DRIVES[candidate.contract]} with --drive"
    )


def require_angles(drive: DriveDocument) -> DriveDocument:
    """Refuse a drive whose controllers answer with no advance angle, where all is about angles."""
    if not kind_of(drive).has_angles:
        raise InputError(
            f"a drive of the kind '{drive.kind}' has no steady states of an advance angle: drivegate drive shows "
            "what it can do over speed and torque, and drivegate compare and simulate what controllers make of it; "
            "or name another drive"
        )
    return drive


def common_drive(candidates: Iterable[Candidate], named: DriveDocument | None = None) -> DriveDocument:
    """Choose the one drive of candidates that are compared."""
    compared = list(candidates)
    drives = [drive_for(candidate, named) for candidate in compared] or [drive_for(None, named)]
    found = [at_declared_timing(drive, compared) for drive in drives]
    first = found[0]
    other = next((drive for drive in found if drive != first), None)
    if other is not None:
        raise InputError(
            f"the candidates' manifests name the drives '{first.name}' and '{other.name}', but candidates are compared "
            "on one; name it with --drive"
        )
    return first
