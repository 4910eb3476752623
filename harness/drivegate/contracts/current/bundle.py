"""The contract of controllers that answer with a current reference and an advance angle."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from drivegate.contracts.contract import Contract, Later, Witness
from drivegate.contracts.current.columns import (
    OBSERVATIONS,
    OUTPUTS,
    PANELS,
    PLOTTED,
    RECORDED_NAMES,
    SENSED,
    SUMMARY_ROWS,
    WINDOW_COLUMNS,
)

if TYPE_CHECKING:
    from hypothesis.strategies import SearchStrategy
    from numpy.typing import NDArray

    from drivegate.candidates.declaration import Declaration
    from drivegate.containment.messages import AnyController
    from drivegate.contracts.contract import RecordedTrace
    from drivegate.contracts.current.record import CurrentRecord
    from drivegate.contracts.current.run import PrepareLoop
    from drivegate_cases.drive.drive_document import DriveDocument
    from drivegate_cases.scenario.scenario import Scenario
    from drivegate_models.contract.current.signals import Nameplate


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


def _nameplate(scenario: Scenario) -> Nameplate:
    return scenario.nameplate()


def _account(trace: RecordedTrace) -> tuple[str, ...]:
    from drivegate.contracts.current.words import account, run_signals

    return account(run_signals(trace))


def _marked_angle(trace: RecordedTrace) -> tuple[float, float] | None:
    from drivegate.contracts.current.words import judged_point, run_signals

    point = judged_point(run_signals(trace))
    return None if point is None else (max(point.begins_s, 0.0), point.edge_deg)


def _common_cause(trace: RecordedTrace) -> str | None:
    from drivegate.contracts.current.words import loss_of_speed, run_signals

    return loss_of_speed(run_signals(trace))


_KINDS: Final = ("half-bridge", "star")

CURRENT: Final = Contract(
    name="current",
    candidates="current-reference candidates",
    default_drive="paper-5-phase",
    usual_candidate="reference",
    witnesses=(
        Witness("reference", _KINDS),
        Witness(
            "informed",
            _KINDS,
            knows_plant=True,
            made_for=Later("drivegate.contracts.current.informed", "InformedController"),
        ),
    ),
    checks=Later("drivegate.contracts.current.checks.catalogue", "CHECKS").value,
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
    numbers=Later("drivegate.contracts.current.numbers", "numbers"),
    fixed_scenarios=_fixed_scenarios,
    drawn_scenarios=_drawn_scenarios,
    joint_scenarios=_joint_scenarios,
    joint_rows=_joint_rows,
    unfair_because=Later("drivegate.contracts.current.scenarios.feasibility", "unfair_because"),
    simplifications=Later("drivegate.contracts.current.scenarios.simplification", "SIMPLIFICATIONS").value,
    drawn_range=Later("drivegate.contracts.current.scenarios.drawn.families", "drawn_range"),
    unseen=Later("drivegate.contracts.current.record", "unseen_record"),
    record=_record,
    judged_window=Later("drivegate.contracts.current.record", "judged_window"),
    step_seconds=Later("drivegate.contracts.current.timed_steps", "current_step_seconds"),
    layout=Later("drivegate_models.contract.layout", "CURRENT").value,
    sensed=SENSED,
    outputs=OUTPUTS,
    plotted=PLOTTED,
    nameplate=_nameplate,
    run=Later("drivegate.contracts.current.run", "run_in_closed_loop"),
    given_steps=Later("drivegate.contracts.current.timed_steps", "given_steps"),
    plant_state=Later("drivegate.contracts.current.run", "plant_state"),
    signals=Later("drivegate.contracts.current.figures", "signals"),
    recorded_signals=Later("drivegate.contracts.current.figures", "recorded_signals"),
    recorded_names=RECORDED_NAMES,
    panels=PANELS,
    account=_account,
    marked_angle=_marked_angle,
    common_cause=_common_cause,
    summary=Later("drivegate.contracts.current.figures", "summary"),
    summary_rows=SUMMARY_ROWS,
    window_columns=WINDOW_COLUMNS,
    observations=OBSERVATIONS,
    observe=Later("drivegate.contracts.current.figures", "observe"),
    rehearsed="published",
    comparison=Later("drivegate.contracts.current.comparison.declaration", "COMPARISON").value,
)
"""A current reference and an advance angle, as the paper's controller gives them."""
