"""The job that times a controller's step on the Senses of a recorded run (TIM-1)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from drivegate.candidates.kinds import KINDS
from drivegate.candidates.python.bridge import PythonController
from drivegate.checks.judging import JudgedRun, ShardOutcome
from drivegate.checks.margin import Margin, below
from drivegate.checks.timing import LARGEST_SHARE
from drivegate.containment.contained_controller import ContainedController
from drivegate.containment.messages import AnyController, JudgedCandidate
from drivegate.contracts.catalogue import contract_of
from drivegate.drives.running import recorded
from drivegate_cases.scenario.scenario import Scenario

CHECK: Final = "TIM-1"


@dataclass(frozen=True)
class TimedSteps:
    """Steps to be timed."""

    scenario: Scenario
    """The run whose first Senses the controller is timed on."""


def time_steps(loaded: JudgedCandidate, plan: TimedSteps) -> ShardOutcome:
    """Record a run, then time the candidate's steps on what it sensed there."""
    controller = loaded.controller()
    scenario = plan.scenario
    record = recorded(loaded, scenario, controller, trace_every=1)
    step_time = contract_of(scenario.drive).step_seconds(controller, record)
    way = way_of_running(loaded.candidate.kind, controller)
    return ShardOutcome(
        (JudgedRun(scenario.to_mapping(), (timing_margin(way, step_time, scenario.control_period_s),)),)
    )


def way_of_running(kind: str, controller: AnyController) -> str:
    """Tell how a candidate's step runs, without which its time says little."""
    is_python = (
        controller.is_python
        if isinstance(controller, ContainedController)
        else isinstance(controller, PythonController)
    )
    return KINDS[kind].way_of_running or ("Python" if is_python else "native")


def timing_margin(way: str, step_time: float, control_period: float) -> Margin:
    """Judge the time of a step."""
    share = step_time / control_period
    measured = f"{1e6 * step_time:.3g} µs a step ({way}), {100.0 * share:.3g} % of the control period"
    return Margin(CHECK, below(step_time, LARGEST_SHARE * control_period), measured)
