"""The contract of controllers that answer with a current reference and an advance angle."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any, Final

from drivegate.candidates.declaration import Declaration
from drivegate.containment.messages import AnyController
from drivegate.contracts.contract import RecordedTrace, Witness
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate.contracts.current.columns import CurrentColumns
from drivegate.contracts.current.figures import observe, recorded_signals, signals, summary
from drivegate.contracts.current.flowchart.run import script_margin, scripted_runs
from drivegate.contracts.current.informed import InformedController
from drivegate.contracts.current.numbers import numbers
from drivegate.contracts.current.record import CurrentRecord, judged_window, unseen_record
from drivegate.contracts.current.run import (
    PrepareLoop,
    observed_windows,
    plant_state,
    run_in_closed_loop,
)
from drivegate.contracts.current.scenarios.feasibility import unfair_because
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
from drivegate.contracts.current.scenarios.simplification import SIMPLIFICATIONS
from drivegate.contracts.current.sensed import empty_steps, sensed_signals
from drivegate.contracts.current.timed_steps import current_step_seconds, given_steps
from drivegate.contracts.current.words import account, judged_point, loss_of_speed, run_signals
from drivegate.contracts.given_steps import RecordingController
from drivegate.scenarios.drawn_range import LIGHTEST_SHARE, NONE, DrawnRange, Interval
from drivegate.scenarios.drive_scale import scale_of
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.contract.layout import CURRENT as LAYOUT

if TYPE_CHECKING:
    from hypothesis.strategies import SearchStrategy
    from numpy.typing import NDArray

    from drivegate.contracts.comparison import Comparison

_KINDS: Final = ("half-bridge", "star")


class _CurrentContract(CurrentColumns):
    """A current reference and an advance angle, as the paper's controller gives them."""

    name = "current"
    candidates = "current-reference candidates"
    usual_candidate = "reference"
    rehearsed = "published"
    witnesses = (
        Witness("reference", _KINDS),
        Witness("informed", _KINDS, knows_plant=True, made_for=InformedController),
    )
    checks = CHECKS
    families = (
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
    )
    simplifications = SIMPLIFICATIONS
    layout = LAYOUT

    numbers = staticmethod(numbers)
    scripted_runs = staticmethod(scripted_runs)
    script_margin = staticmethod(script_margin)
    unfair_because = staticmethod(unfair_because)
    unseen = staticmethod(unseen_record)
    judged_window = staticmethod(judged_window)
    step_seconds = staticmethod(current_step_seconds)
    run = staticmethod(run_in_closed_loop)
    given_steps = staticmethod(given_steps)
    plant_state = staticmethod(plant_state)
    signals = staticmethod(signals)
    recorded_signals = staticmethod(recorded_signals)
    sensed_signals = staticmethod(sensed_signals)
    summary = staticmethod(summary)
    observe = staticmethod(observe)

    def settled_until(self, scenario: Scenario, /) -> tuple[float, ...]:
        return tuple(end for _, end in observed_windows(scenario))

    def fixed_scenarios(self, drive: DriveDocument, declaration: Declaration) -> tuple[Scenario, ...]:
        return fixed_scenarios(drive, declaration.speed_range_rpm)

    def drawn_scenarios(
        self, drive: DriveDocument, declaration: Declaration, group: int | None
    ) -> SearchStrategy[Scenario]:
        from drivegate.contracts.current.scenarios.drawn.families import drawn_scenarios

        return drawn_scenarios(drive, declaration.speed_range_rpm, group)

    def drawn_range(self, scenario: Scenario) -> DrawnRange:
        scale = scale_of(scenario.drive)
        return DrawnRange(
            loaded_rpm=Interval(scale.lowest_loaded_rpm, scale.highest_loaded_rpm),
            idle_rpm=Interval(0.0, scale.highest_loaded_rpm),
            driving_share=Interval(LIGHTEST_SHARE, 1.0),
            braking_share=NONE,
        )

    def joint_rows(self) -> int:
        from drivegate.scenarios.covering import covering_rows

        return len(covering_rows())

    def joint_scenarios(
        self, drive: DriveDocument, declaration: Declaration, seed: int, part: int, parts: int
    ) -> tuple[Scenario, ...]:
        from drivegate.contracts.current.scenarios.combined import combined_scenarios

        return combined_scenarios(drive, declaration.speed_range_rpm, seed, part, parts)

    def record(
        self,
        prepare: PrepareLoop,
        declaration: Declaration,
        scenario: Scenario,
        controller: AnyController,
        *,
        trace_every: int = 0,
        kept: NDArray[Any] | None = None,
        keeps_steps: bool = False,
    ) -> CurrentRecord:
        steps = empty_steps(scenario, trace_every) if keeps_steps and trace_every > 0 else None
        run = run_in_closed_loop(
            prepare,
            scenario,
            controller,
            trace_every=trace_every,
            power_window=declaration.power_window_s,
            kept=kept,
            wrap=None if steps is None else partial(RecordingController, rows=steps, every=trace_every),
        )
        return CurrentRecord(scenario, run, declaration, steps=steps)

    def account(self, trace: RecordedTrace) -> tuple[str, ...]:
        return account(run_signals(trace))

    def marked_angle(self, trace: RecordedTrace) -> tuple[float, float] | None:
        point = judged_point(run_signals(trace))
        return None if point is None else (max(point.begins_s, 0.0), point.edge_deg)

    def common_cause(self, trace: RecordedTrace) -> str | None:
        return loss_of_speed(run_signals(trace))

    def comparison(self) -> Comparison:
        from drivegate.contracts.current.comparison.declaration import COMPARISON

        return COMPARISON


CURRENT: Final = _CurrentContract()
"""The contract."""
