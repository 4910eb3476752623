"""The contract of controllers that answer with duty ratios."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from drivegate.contracts.contract import Contract
from drivegate.contracts.duty.columns import (
    OBSERVATIONS,
    OUTPUTS,
    PLOTTED,
    RECORDED_NAMES,
    SENSED,
    SUMMARY_ROWS,
    WINDOW_COLUMNS,
)
from drivegate.contracts.witness import Witness

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from hypothesis.strategies import SearchStrategy
    from numpy.typing import NDArray

    from drivegate.candidates.declaration import Declaration
    from drivegate.checks.check import Check
    from drivegate.checks.margin import Margin
    from drivegate.checks.record import Record
    from drivegate.containment.messages import AnyController
    from drivegate.containment.playback import Wrap
    from drivegate.contracts.comparison import Comparison
    from drivegate.contracts.duty.record import DutyRecord
    from drivegate.contracts.duty.run import DutyClosedLoopRun, PrepareDutyLoop
    from drivegate.contracts.given_steps import GivenSteps
    from drivegate.contracts.trace import RecordedTrace
    from drivegate.scenarios.drawn_range import DrawnRange
    from drivegate.scenarios.simplification import Simplification
    from drivegate_cases.drive.drive_document import DriveDocument
    from drivegate_cases.scenario.scenario import Scenario
    from drivegate_models.contract.duty.signals import DutyNameplate
    from drivegate_models.contract.layout import Layout


def _checks() -> tuple[Check, ...]:
    from drivegate.contracts.duty.checks.catalogue import DUTY_CHECKS

    return DUTY_CHECKS


def _numbers(drive: DriveDocument) -> Mapping[str, str]:
    from drivegate.contracts.duty.numbers import numbers

    return numbers(drive)


def _fixed_scenarios(drive: DriveDocument, declaration: Declaration) -> tuple[Scenario, ...]:
    from drivegate.contracts.duty.document import duty_document
    from drivegate.contracts.duty.scenarios.fixed import fixed_scenarios

    return fixed_scenarios(duty_document(drive), declaration.references, declaration.detects)


def _drawn_scenarios(
    drive: DriveDocument, declaration: Declaration, group: int | None
) -> SearchStrategy[Scenario]:
    from drivegate.contracts.duty.document import duty_document
    from drivegate.contracts.duty.scenarios.drawn import drawn_scenarios

    return drawn_scenarios(duty_document(drive), group, declaration.references, declaration.detects)


def _no_joint_scenarios(*_: object) -> tuple[Scenario, ...]:
    """Return none: what is varied jointly are sensors, disturbances and beginnings of the other contract."""
    return ()


def _no_joint_rows() -> int:
    return 0


def _unfair_because(scenario: Scenario) -> str | None:
    from drivegate.contracts.duty.scenarios.feasibility import unfair_because

    return unfair_because(scenario)


def _simplifications() -> tuple[Simplification, ...]:
    from drivegate.contracts.duty.scenarios.simplification import DUTY_SIMPLIFICATIONS

    return DUTY_SIMPLIFICATIONS


def _drawn_range(scenario: Scenario) -> DrawnRange:
    from drivegate.contracts.duty.scenarios.drawn_range import drawn_range

    return drawn_range(scenario)


def _unseen(declaration: Declaration, scenario: Scenario) -> DutyRecord:
    from drivegate.contracts.duty.unseen import unseen_duty_record

    return unseen_duty_record(declaration, scenario)


def _record(
    prepare: PrepareDutyLoop,
    declaration: Declaration,
    scenario: Scenario,
    controller: AnyController,
    *,
    trace_every: int = 0,  # noqa: ARG001  (every run of this contract keeps its whole trace)
    kept: NDArray[Any] | None = None,
) -> DutyRecord:
    from drivegate.contracts.duty.plant_run import duty_run
    from drivegate.contracts.duty.record import DutyRecord
    from drivegate.contracts.duty.scenarios.dead_time import with_other_dead_time

    run = duty_run(prepare, scenario, controller)
    if kept is not None:
        kept[:] = run.commands
    compared = with_other_dead_time(scenario)
    other = (
        None
        if compared is None
        else DutyRecord(compared, duty_run(prepare, compared, controller), declaration)
    )
    return DutyRecord(scenario, run, declaration, other_dead_time=other)


def _judged_window(_check: Check, record: Record, _margin: Margin | None) -> tuple[float, float]:
    """Return the whole run: these checks judge steps and whole runs too, and state the place in words."""
    return (0.0, record.scenario.duration_s)


def _step_seconds(controller: AnyController, record: Record) -> float:
    from drivegate.contracts.duty.timed_steps import duty_step_seconds

    return duty_step_seconds(controller, record)


def _layout() -> Layout:
    from drivegate_models.contract.layout import DUTY

    return DUTY


def _nameplate(scenario: Scenario) -> DutyNameplate:
    from drivegate.contracts.duty.run import duty_nameplate

    return duty_nameplate(scenario)


def _run(
    prepare: PrepareDutyLoop, scenario: Scenario, controller: AnyController, wrap: Wrap | None = None
) -> DutyClosedLoopRun:
    from drivegate.contracts.duty.plant_run import duty_run

    return duty_run(prepare, scenario, controller, wrap)


def _given_steps(controller: AnyController, nameplate: DutyNameplate) -> GivenSteps:
    from drivegate.contracts.duty.timed_steps import given_duty_steps

    return given_duty_steps(controller, nameplate)


def _plant_state(
    prepare: PrepareDutyLoop, scenario: Scenario, commands: NDArray[Any], step: int
) -> dict[str, Any]:
    from drivegate.contracts.duty.plant_state import plant_state

    return plant_state(prepare, scenario, commands, step)


def _signals(run: DutyClosedLoopRun) -> dict[str, NDArray[Any]]:
    from drivegate.contracts.duty.figures import signals

    return signals(run)


def _account(trace: RecordedTrace) -> tuple[str, ...]:
    from drivegate.contracts.duty.words import duty_account, duty_signals

    return duty_account(duty_signals(trace))


def _nothing(_trace: RecordedTrace) -> None:
    """Return no mark and no common cause: there is no advance angle."""
    return


def _summary(record: Any) -> dict[str, Any]:
    from drivegate.contracts.duty.figures import summary

    return summary(record)


def _observe(record: Record) -> dict[str, float]:
    from drivegate.contracts.duty.figures import observe

    return observe(record)


def _behaviour(
    run: Callable[[Scenario], Record], drive: DriveDocument, step: Scenario | None
) -> dict[str, Any]:
    from drivegate.contracts.duty.behaviour import behaviour
    from drivegate.contracts.duty.document import duty_document

    return behaviour(run, duty_document(drive), step)


def _comparison() -> Comparison:
    from drivegate.contracts.duty.comparison.declaration import COMPARISON

    return COMPARISON


DUTY: Final = Contract(
    name="duty",
    default_drive="pm-ac-interior",
    usual_candidate="foc",
    witnesses=tuple(
        Witness(name, ("pm-ac",)) for name in ("foc", "predictive-flux", "direct-torque", "foc-loss-model")
    ),
    checks=_checks,
    families=(
        "torque step",
        "weakening",
        "speed step",
        "load step",
        "low speed",
        "start",
        "parameter",
        "supply step",
        "torque supply step",
        "sensor",
        "failure",
    ),
    numbers=_numbers,
    fixed_scenarios=_fixed_scenarios,
    drawn_scenarios=_drawn_scenarios,
    joint_scenarios=_no_joint_scenarios,
    joint_rows=_no_joint_rows,
    unfair_because=_unfair_because,
    simplifications=_simplifications,
    drawn_range=_drawn_range,
    unseen=_unseen,
    record=_record,
    judged_window=_judged_window,
    step_seconds=_step_seconds,
    layout=_layout,
    sensed=SENSED,
    outputs=OUTPUTS,
    plotted=PLOTTED,
    nameplate=_nameplate,
    run=_run,
    given_steps=_given_steps,
    plant_state=_plant_state,
    signals=_signals,
    recorded_signals=_signals,
    recorded_names=RECORDED_NAMES,
    account=_account,
    marked_angle=_nothing,
    common_cause=_nothing,
    summary=_summary,
    summary_rows=SUMMARY_ROWS,
    window_columns=WINDOW_COLUMNS,
    observations=OBSERVATIONS,
    observe=_observe,
    rehearsed="foc-mtpa",
    comparison=_comparison,
    behaviour=_behaviour,
)
"""Three duty ratios, as the firmware of a PM AC drive writes them to its timer."""
