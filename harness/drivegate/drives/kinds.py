"""All kinds of drives, each a plant with the name of its contract, and which of them a drive belongs to."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Protocol, TypeAlias

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.contract import ANSWERS
from drivegate.contracts.catalogue import CONTRACTS, DEFAULT_CONTRACT
from drivegate_cases.documents.wording import one_line
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from drivegate_cases.drive.drive_document import DriveDocument
    from drivegate_cases.scenario.scenario import Scenario
    from drivegate_models.steady.oracle import AdvanceLine as AdvanceLine
    from drivegate_models.steady.oracle import GreatestTorque, Optimum, TorquePoint

FloatArray: TypeAlias = "NDArray[np.float64]"
Drive: TypeAlias = Any
"""Constants of a plant, as its own kind of drive has them."""


class Oracle(Protocol):
    """What a drive can do at best, whatever the controller: functions of its constants, in SI units."""

    def feasible_edge(
        self, drive: Drive, speed: float, torque: float, voltage: float | None = None, static: bool = False
    ) -> float:
        """Find the smallest advance angle that gives a torque; NaN where none does."""

    def least_current_sum(
        self, drive: Drive, speed: float, torque: float, voltage: float | None = None
    ) -> Optimum:
        """Find the advance angle that gives a torque with the least current sum."""

    def least_input_power(self, drive: Drive, speed: float, torque: float) -> Optimum:
        """Find the advance angle that gives a torque with the least input power."""

    def point_at_torque(
        self, drive: Drive, speed: float, advance: float, torque: float, voltage: float | None = None
    ) -> TorquePoint:
        """Find the steady state that gives a torque at an advance angle."""

    def greatest_torque_at_limit(self, drive: Drive, speed: float) -> GreatestTorque:
        """Find the advance angle of the greatest torque at the current limit."""

    def torques_at_limit(self, drive: Drive, speed: float, advances: ArrayLike) -> FloatArray:
        """Find the torques at the current limit along the advance angle."""

    def demanded_torque(self, drive: Drive, speed: float, base_speed: float, rated_power: float) -> float:
        """Find the torque of rated power at a speed, constant below base speed."""

    def recommended_line(
        self, drive: Drive, base_speed: float, highest_speed: float, rated_power: float
    ) -> AdvanceLine:
        """Find the line of initial angles that keeps rated power at the least advance."""


@dataclass(frozen=True, kw_only=True)
class SteadyStates:
    """The solver of many steady states."""

    columns: tuple[str, ...]
    """Names of what is computed of each."""
    solve: Callable[[Drive, FloatArray, FloatArray, FloatArray, FloatArray], None]
    """From a drive's constants and arrays of speed (rad/s), advance angle (rad) and current reference (A) to
    rows of those columns, which it writes into its last argument."""


@dataclass(frozen=True, kw_only=True)
class AngleStudies:
    """What is computed of drives whose controllers answer with an advance angle; each function imports its kernels."""

    oracle: Callable[[], Oracle]
    """Return what such a drive can do at best."""
    steady_state: Callable[[], Callable[..., object]]
    """Return the solver of one steady state."""
    steady_states: Callable[[], SteadyStates]
    """Return the solver of many steady states."""


@dataclass(frozen=True, kw_only=True)
class DriveKind:
    """A kind of drive; a bundle imports no compiled code until it is called."""

    name: str
    """The kind, as documents of drives have it."""
    contract: str
    """Name of the contract of its controllers."""
    default_drive: str
    """Name of the packaged drive that stands for this kind."""
    compiling_s: int
    """Time to compile its kernels on 2 processors, as measured (s)."""
    prepare_loop: Callable[[], Callable[..., Any]]
    """Return the function that prepares a run of a controller against the plant."""
    angles: AngleStudies | None = None
    """Studies over the advance angle; None where controllers answer with none."""

    def oracle(self) -> Oracle:
        """Return what a drive of this kind can do at best over the advance angle."""
        return self.require_angles().oracle()

    def steady_state(self) -> Callable[..., object]:
        """Return the solver of one steady state at an advance angle."""
        return self.require_angles().steady_state()

    def steady_states(self) -> SteadyStates:
        """Return the solver of many steady states at advance angles."""
        return self.require_angles().steady_states()

    def require_angles(self) -> AngleStudies:
        """Return the studies over the advance angle, or refuse a kind without them."""
        if self.angles is None:
            raise InputError(
                f"a drive of the kind '{self.name}' has no steady states of an advance angle: drivegate drive shows "
                "what it can do over speed and torque, and drivegate compare and simulate what controllers make of it; "
                "or name another drive"
            )
        return self.angles


def _oracle() -> Oracle:
    from drivegate_models.steady import oracle

    return oracle


def _steady_state() -> Callable[..., object]:
    from drivegate_models.steady.steady_state import steady_state

    return steady_state


def _steady_states() -> SteadyStates:
    from drivegate_models.steady.grid import POINT_COLUMNS, solve_points
    from drivegate_models.steady.plant import make_phases
    from drivegate_models.steady.steady_state import KEPT_TIME

    def solve(
        drive: Drive, speeds: FloatArray, advances: FloatArray, references: FloatArray, values: FloatArray
    ) -> None:
        work, slices = make_phases(drive, KEPT_TIME), make_phases(drive)
        solve_points(drive, work, slices, drive.half_supply_voltage, speeds, advances, references, values)

    return SteadyStates(columns=POINT_COLUMNS, solve=solve)


def _half_bridge_loop() -> Callable[..., Any]:
    from drivegate_models.half_bridge.closed_loop import prepared_loop

    return prepared_loop


def _star_loop() -> Callable[..., Any]:
    from drivegate_models.star.closed_loop import prepared_loop

    return prepared_loop


def _pm_ac_loop() -> Callable[..., Any]:
    from drivegate_models.pm_ac.closed_loop import prepared_duty_loop

    return prepared_duty_loop


_ANGLES: Final = AngleStudies(oracle=_oracle, steady_state=_steady_state, steady_states=_steady_states)
HALF_BRIDGE: Final = DriveKind(
    name="half-bridge",
    contract="current",
    default_drive="paper-5-phase",
    compiling_s=20,
    prepare_loop=_half_bridge_loop,
    angles=_ANGLES,
)
"""The phase-decoupled machine on half-bridge legs at a split supply: the drive of the paper."""
STAR: Final = DriveKind(
    name="star",
    contract="current",
    default_drive="star-3-phase",
    compiling_s=20,
    prepare_loop=_star_loop,
    angles=_ANGLES,
)
"""The star-connected machine with an isolated neutral: conventional brushless DC drives."""
PM_AC: Final = DriveKind(
    name="pm-ac", contract="duty", default_drive="pm-ac-interior", compiling_s=25, prepare_loop=_pm_ac_loop
)
"""The d-q machine on a two-level bridge: three sinusoidal phases, as most brushless drives have them."""

DRIVE_KINDS: Final[Mapping[str, DriveKind]] = {kind.name: kind for kind in (HALF_BRIDGE, STAR, PM_AC)}
"""Every kind by its name, which is the `kind` of its documents."""
DEFAULT_KIND: Final = HALF_BRIDGE
"""The kind that controllers are made for by default."""
DEFAULT_DRIVE: Final = DEFAULT_CONTRACT.default_drive
"""Name of the drive that is meant by default."""
DEFAULT_DRIVES: Final[Mapping[str, str]] = {name: bundle.default_drive for name, bundle in CONTRACTS.items()}
"""Name of the drive that a candidate of each contract is judged on by default."""


def kind_of(drive: DriveDocument) -> DriveKind:
    """Return the kind that a drive belongs to."""
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
    """Refuse a candidate of one contract on a drive of another."""
    if candidate.contract in (None, drive.contract):
        return
    raise InputError(
        f"the candidate '{one_line(candidate.name)}' answers with {ANSWERS[candidate.contract]}, but the drive "
        f"'{one_line(drive.name)}' of the kind '{drive.kind}' takes {ANSWERS[drive.contract]}; name a drive such as "
        f"{DEFAULT_DRIVES[candidate.contract]} with --drive"
    )


def require_angles(drive: DriveDocument) -> DriveDocument:
    """Refuse a drive whose controllers answer with no advance angle, where all is about angles."""
    kind_of(drive).require_angles()
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
