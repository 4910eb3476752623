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
from drivegate.contracts.current.timed_steps import senses_of_run, step_seconds
from drivegate.contracts.duty.timed_steps import duty_step_seconds
from drivegate.drives.running import recorded, run_scenario
from drivegate_cases.scenario.scenario import Scenario

CHECK: Final = "TIM-1"


@dataclass(frozen=True)
class TimedSteps:
    """Steps to be timed.

    Attributes
    ----------
    scenario : Scenario
        The run whose first Senses the controller is timed on.
    """

    scenario: Scenario


def time_steps(loaded: JudgedCandidate, plan: TimedSteps) -> ShardOutcome:
    """Record a run, then time the candidate's steps on what it sensed there."""
    controller = loaded.controller()
    scenario = plan.scenario
    if scenario.drive.contract == "current":
        run = run_scenario(scenario, controller, trace_every=1)
        nameplate = scenario.nameplate()
        step_time = step_seconds(controller, nameplate, senses_of_run(run, nameplate))
    else:
        step_time = duty_step_seconds(controller, recorded(loaded, scenario, controller))
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
