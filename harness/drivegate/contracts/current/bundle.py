"""The contract of controllers that answer with a current reference and an advance angle."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from drivegate.contracts.contract import Contract
from drivegate.contracts.current.columns import (
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
    from collections.abc import Mapping

    from hypothesis.strategies import SearchStrategy
    from numpy.typing import NDArray

    from drivegate.candidates.declaration import Declaration
    from drivegate.checks.check import Check
    from drivegate.checks.margin import Margin
    from drivegate.containment.messages import AnyController
    from drivegate.containment.playback import Wrap
    from drivegate.contracts.comparison import Comparison
    from drivegate.contracts.current.record import CurrentRecord
    from drivegate.contracts.current.run import PrepareLoop
    from drivegate.contracts.given_steps import GivenSteps
    from drivegate.contracts.trace import RecordedTrace
    from drivegate.scenarios.drawn_range import DrawnRange
    from drivegate.scenarios.simplification import Simplification
    from drivegate_cases.drive.drive_document import DriveDocument
    from drivegate_cases.scenario.scenario import Scenario
    from drivegate_models.contract.current.signals import Nameplate
    from drivegate_models.contract.layout import Layout
    from drivegate_models.loop.closed_loop import ClosedLoopRun


def _checks() -> tuple[Check, ...]:
    from drivegate.contracts.current.checks.catalogue import CHECKS

    return CHECKS


def _numbers(drive: DriveDocument) -> Mapping[str, str]:
    from drivegate.contracts.current.numbers import numbers

    return numbers(drive)


def _fixed_scenarios(drive: DriveDocument, declaration: Declaration) -> tuple[Scenario, ...]:
    from drivegate.contracts.current.scenarios.fixed import fixed_scenarios

    return fixed_scenarios(drive, declaration.speed_range_rpm)


def _drawn_scenarios(
    drive: DriveDocument, declaration: Declaration, group: int | None
) -> SearchStrategy[Scenario]:
    from drivegate.contracts.current.scenarios.drawn.families import drawn_scenarios

    return drawn_scenarios(drive, declaration.speed_range_rpm, group)


def _joint_scenarios(
    drive: DriveDocument, declaration: Declaration, seed: int, part: int, parts: int
) -> tuple[Scenario, ...]:
    from drivegate.contracts.current.scenarios.combined import combined_scenarios

    return combined_scenarios(drive, declaration.speed_range_rpm, seed, part, parts)


def _joint_rows() -> int:
    from drivegate.scenarios.covering import covering_rows

    return len(covering_rows())


def _unfair_because(scenario: Scenario) -> str | None:
    from drivegate.contracts.current.scenarios.feasibility import unfair_because

    return unfair_because(scenario)


def _simplifications() -> tuple[Simplification, ...]:
    from drivegate.contracts.current.scenarios.simplification import SIMPLIFICATIONS

    return SIMPLIFICATIONS


def _drawn_range(scenario: Scenario) -> DrawnRange:
    from drivegate.contracts.current.scenarios.drawn_range import drawn_range

    return drawn_range(scenario)


def _unseen(declaration: Declaration, scenario: Scenario) -> CurrentRecord:
    from drivegate.contracts.current.record import unseen_record

    return unseen_record(declaration, scenario)


def _record(
    prepare: PrepareLoop,
    declaration: Declaration,
    scenario: Scenario,
    controller: AnyController,
    *,
    trace_every: int = 0,
    kept: NDArray[Any] | None = None,
) -> CurrentRecord:
    from drivegate.contracts.current.record import CurrentRecord
    from drivegate.contracts.current.run import run_in_closed_loop

    run = run_in_closed_loop(
        prepare,
        scenario,
        controller,
        trace_every=trace_every,
        power_window=declaration.power_window_s,
        kept=kept,
    )
    return CurrentRecord(scenario, run, declaration)


def _judged_window(check: Check, record: Any, margin: Margin | None) -> tuple[float, float]:
    from drivegate.contracts.current.judged_window import judged_window

    return judged_window(check, record, margin)


def _step_seconds(controller: AnyController, record: Any) -> float:
    from drivegate.contracts.current.timed_steps import current_step_seconds

    return current_step_seconds(controller, record)


def _layout() -> Layout:
    from drivegate_models.contract.layout import CURRENT

    return CURRENT


def _nameplate(scenario: Scenario) -> Nameplate:
    return scenario.nameplate()


def _run(
    prepare: PrepareLoop, scenario: Scenario, controller: AnyController, wrap: Wrap | None = None
) -> ClosedLoopRun:
    from drivegate.contracts.current.run import run_in_closed_loop

    return run_in_closed_loop(prepare, scenario, controller, wrap=wrap)


def _given_steps(controller: AnyController, nameplate: Nameplate) -> GivenSteps:
    from drivegate.contracts.current.timed_steps import given_steps

    return given_steps(controller, nameplate)


def _plant_state(
    prepare: PrepareLoop, scenario: Scenario, commands: NDArray[Any], step: int
) -> dict[str, Any]:
    from drivegate.contracts.current.plant_state import plant_state

    return plant_state(prepare, scenario, commands, step)


def _signals(run: ClosedLoopRun) -> dict[str, NDArray[Any]]:
    from drivegate.contracts.current.figures import signals

    return signals(run)


def _recorded_signals(run: ClosedLoopRun) -> dict[str, NDArray[Any]]:
    from drivegate.contracts.current.figures import recorded_signals

    return recorded_signals(run)


def _account(trace: RecordedTrace) -> tuple[str, ...]:
    from drivegate.contracts.current.words.account import account
    from drivegate.contracts.current.words.run_signals import run_signals

    return account(run_signals(trace))


def _marked_angle(trace: RecordedTrace) -> tuple[float, float] | None:
    from drivegate.contracts.current.words.judged_point import judged_point
    from drivegate.contracts.current.words.run_signals import run_signals

    point = judged_point(run_signals(trace))
    return None if point is None else (max(point.begins_s, 0.0), point.edge_deg)


def _common_cause(trace: RecordedTrace) -> str | None:
    from drivegate.contracts.current.words.account import loss_of_speed
    from drivegate.contracts.current.words.run_signals import run_signals

    return loss_of_speed(run_signals(trace))


def _summary(record: Any) -> dict[str, Any]:
    from drivegate.contracts.current.figures import summary

    return summary(record)


def _observe(record: Any) -> dict[str, float]:
    from drivegate.contracts.current.figures import observe

    return observe(record)


def _comparison() -> Comparison:
    from drivegate.contracts.current.comparison.declaration import COMPARISON

    return COMPARISON


_KINDS: Final = ("half-bridge", "star")

CURRENT: Final = Contract(
    name="current",
    default_drive="paper-5-phase",
    usual_candidate="reference",
    witnesses=(
        Witness("reference", _KINDS),
        # These have a table of the drive's angles, computed from its nominal constants.
        *(
            Witness(f"design:{name}", _KINDS, knows_plant=True)
            for name in ("angle-table", "golden-section", "quadratic-interpolation", "sweep")
        ),
    ),
    checks=_checks,
    families=(
        "steady",
        "constant power",
        "required point",
        "parameter",
        "load step",
        "load course",
        "sensor",
        "phase",
        "supply",
        "beginning",
        "fault",
        "restart",
        "speed step",
        "standstill",
        "base speed",
        "overspeed",
        "vehicle",
    ),
    numbers=_numbers,
    fixed_scenarios=_fixed_scenarios,
    drawn_scenarios=_drawn_scenarios,
    joint_scenarios=_joint_scenarios,
    joint_rows=_joint_rows,
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
    recorded_signals=_recorded_signals,
    recorded_names=RECORDED_NAMES,
    account=_account,
    marked_angle=_marked_angle,
    common_cause=_common_cause,
    summary=_summary,
    summary_rows=SUMMARY_ROWS,
    window_columns=WINDOW_COLUMNS,
    observations=OBSERVATIONS,
    observe=_observe,
    rehearsed="published",
    comparison=_comparison,
)
"""A current reference and an advance angle, as the paper's controller gives them."""
