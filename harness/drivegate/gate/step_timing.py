"""The job that times a controller's step on the Senses of a recorded run (TIM-1)."""

from __future__ import annotations

from dataclasses import dataclass
from statistics import median
from time import perf_counter
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.controller import Controller
from drivegate.candidates.kinds import KINDS
from drivegate.candidates.python.bridge import PythonController
from drivegate.checks.judging import JudgedRun, ShardOutcome
from drivegate.checks.margin import Margin, below
from drivegate.checks.timing import LARGEST_SHARE
from drivegate.containment.messages import LoadedCandidate
from drivegate.drives.running import run_scenario
from drivegate.runs.scripted import advance, prepared_steps
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.units import RADIANS_PER_RPM

CHECK: Final = "TIM-1"
TIMED_STEPS: Final = 4000
"""Number of steps that are timed."""
BLOCK: Final = 100
"""Number of steps whose mean time is taken; a decision of a search in 200 steps counts in every other one."""
_COLUMNS: Final = ("speed_reference_rpm", "measured_speed_rpm", "current_sum_a", "half_supply_v")


@dataclass(frozen=True)
class TimedSteps:
    """Steps to be timed.

    Attributes
    ----------
    scenario : Scenario
        The run whose first Senses the controller is timed on.
    """

    scenario: Scenario


def time_steps(loaded: LoadedCandidate, plan: TimedSteps) -> ShardOutcome:
    """Record a run, then time the candidate's steps on what it sensed there."""
    controller = loaded.controller()
    scenario = plan.scenario
    period = scenario.control_period_s
    steps = min(TIMED_STEPS, scenario.control_periods)
    run = run_scenario(scenario, controller, progress=loaded.progress, trace_every=1)
    signals = _signals(run.trace[:steps])
    times = []
    with loaded.progress.run():
        prepared = prepared_steps(controller, scenario.nameplate(), signals, loaded.progress)
        for begin in range(0, steps, BLOCK):
            end = min(begin + BLOCK, steps)
            started = perf_counter()
            advance(prepared, controller, begin, end)
            times.append((perf_counter() - started) / (end - begin))
    # What the machine does besides, or compiles at first, is in few blocks.
    margin = timing_margin(way_of_running(loaded.candidate.kind, controller), median(times), period)
    return ShardOutcome((JudgedRun(scenario.to_mapping(), (margin,)),))


def way_of_running(kind: str, controller: Controller) -> str:
    """Tell how a candidate's step runs, without which its time says little."""
    by_itself = "Python" if isinstance(controller, PythonController) else "native"
    return KINDS[kind].way_of_running or by_itself


def timing_margin(way: str, step_time: float, control_period: float) -> Margin:
    """Judge the time of a step."""
    share = step_time / control_period
    measured = f"{1e6 * step_time:.3g} µs a step ({way}), {100.0 * share:.3g} % of the control period"
    return Margin(CHECK, below(step_time, LARGEST_SHARE * control_period), measured)


def _signals(trace: NDArray[Any]) -> NDArray[np.float64]:
    """Return the Senses of a trace as signals in SI units; the sum given is that of the step before."""
    signals = np.stack([trace[name] for name in _COLUMNS], axis=1)
    signals[:, :2] *= RADIANS_PER_RPM
    signals[1:, 2] = signals[:-1, 2]
    signals[0, 2] = 0.0
    return np.ascontiguousarray(signals)
