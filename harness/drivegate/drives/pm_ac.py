"""The d-q machine on a two-level bridge, whose controllers answer with duty ratios."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, NoReturn

from drivegate.drives.drive_kind import DriveKind
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

    from hypothesis.strategies import SearchStrategy
    from numpy.typing import NDArray

    from drivegate.candidates.declaration import Declaration
    from drivegate.checks.check import Check
    from drivegate.containment.messages import AnyController
    from drivegate.runs.record import RunRecord
    from drivegate.scenarios.drawn_range import DrawnRange
    from drivegate.scenarios.simplification import Simplification
    from drivegate_cases.drive.drive_document import DriveDocument
    from drivegate_cases.drive.pm_ac.document import PmAcDocument
    from drivegate_cases.scenario.scenario import Scenario


def _no_angles(*_: object) -> NoReturn:
    """Say that there are no steady states of an angle, and which commands tell of such a drive."""
    raise InputError(
        "a drive of the kind 'pm-ac' has no steady states of an advance angle: drivegate drive shows what it can do "
        "over speed and torque, and drivegate compare and simulate what controllers make of it; or name another drive"
    )


def _checks() -> tuple[Check, ...]:
    from drivegate.checks.duty.catalogue import DUTY_CHECKS

    return DUTY_CHECKS


def _document(drive: DriveDocument) -> PmAcDocument:
    from drivegate_cases.drive.pm_ac.document import PmAcDocument

    assert isinstance(drive, PmAcDocument), "a drive of this kind has this document"
    return drive


def _fixed_scenarios(drive: DriveDocument, declaration: Declaration) -> tuple[Scenario, ...]:
    from drivegate.scenarios.duty.fixed import fixed_scenarios

    return fixed_scenarios(_document(drive), declaration.references, declaration.detects)


def _drawn_scenarios(
    drive: DriveDocument, declaration: Declaration, group: int | None
) -> SearchStrategy[Scenario]:
    from drivegate.scenarios.duty.drawn import drawn_scenarios

    return drawn_scenarios(_document(drive), group, declaration.references, declaration.detects)


def _joint_scenarios(*_: object) -> tuple[Scenario, ...]:
    """Give none: what is varied jointly are the sensors, disturbances and beginnings of the other kinds."""
    return ()


def _unfair_because(scenario: Scenario) -> str | None:
    from drivegate.scenarios.duty.feasibility import unfair_because

    return unfair_because(scenario)


def _simplifications() -> tuple[Simplification, ...]:
    from drivegate.scenarios.duty.simplification import DUTY_SIMPLIFICATIONS

    return DUTY_SIMPLIFICATIONS


def _drawn_range(scenario: Scenario) -> DrawnRange:
    from drivegate.scenarios.duty.drawn_range import drawn_range

    return drawn_range(scenario)


def _record(
    declaration: Declaration, scenario: Scenario, controller: AnyController, kept: NDArray[Any] | None
) -> RunRecord:
    from drivegate.drives.pm_ac_run import duty_run
    from drivegate.runs.duty.record import DutyRecord
    from drivegate.scenarios.duty.dead_time import with_other_dead_time

    run = duty_run(scenario, controller)
    if kept is not None:
        kept[:] = run.commands
    compared = with_other_dead_time(scenario)
    other = None if compared is None else DutyRecord(compared, duty_run(compared, controller), declaration)
    return DutyRecord(scenario, run, declaration, other_dead_time=other)


def _unseen(declaration: Declaration, scenario: Scenario) -> RunRecord:
    from drivegate.runs.duty.unseen import unseen_duty_record

    return unseen_duty_record(declaration, scenario)


def _behaviour(
    run: Callable[[Scenario], RunRecord], drive: DriveDocument, step: Scenario | None
) -> dict[str, Any]:
    from drivegate.drives.pm_ac_behaviour import behaviour

    return behaviour(run, _document(drive), step)


PM_AC: Final = DriveKind(
    name="pm-ac",
    default_drive="pm-ac-interior",
    compiling_s=80,
    prepare_loop=_no_angles,
    oracle=_no_angles,
    steady_state=_no_angles,
    steady_states=_no_angles,
    checks=_checks,
    fixed_scenarios=_fixed_scenarios,
    drawn_scenarios=_drawn_scenarios,
    joint_scenarios=_joint_scenarios,
    unfair_because=_unfair_because,
    simplifications=_simplifications,
    drawn_range=_drawn_range,
    usual_candidate="foc",
    record=_record,
    unseen=_unseen,
    behaviour=_behaviour,
)
"""Most brushless drives of the world: three sinusoidal phases behind a two-level bridge."""
