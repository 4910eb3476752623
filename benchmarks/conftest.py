"""What the benchmarks share: the drive, one run, and the rate at which simulated time passes."""

from collections.abc import Callable
from typing import Any

import pytest

from drivegate.candidates.controller import Controller
from drivegate.candidates.loading import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.runs.scenario import run_scenario
from drivegate_cases.scenario.scenario import Scenario, load_scenario
from drivegate_models.loop import observation
from drivegate_models.loop.closed_loop import ClosedLoopRun

SIMULATED_SECONDS = 4.0


@pytest.fixture(scope="session")
def published_point() -> Scenario:
    """Return a run at 1500 rpm and 9.8 N·m with a control period of 0.5 ms."""
    return load_scenario("fig5-search").replaced(duration_s=SIMULATED_SECONDS)


@pytest.fixture
def controller() -> Callable[[str], Controller]:
    """Return a function that loads a candidate by its name."""
    return lambda name: load_controller(resolve_candidate(name))


@pytest.fixture
def closed_loop_rate(benchmark: Any) -> Callable[[Scenario, Controller], float]:
    """Return a function that measures simulated seconds a second, on a run whose result is valid."""

    def measure(scenario: Scenario, subject: Controller) -> float:
        run: ClosedLoopRun = run_scenario(scenario, subject)
        speed = float(run.run[observation.RUN_SPEED_FINAL])
        assert abs(speed - 157.08) < 0.6, f"the run ended at {speed} rad/s, not at 1500 rpm"
        assert run.run[observation.RUN_EXCHANGE_ERROR] < 1e-9, "the energy does not close"
        benchmark.pedantic(run_scenario, args=(scenario, subject), rounds=7, warmup_rounds=1)
        rate = scenario.duration_s / float(benchmark.stats.stats.min)
        benchmark.extra_info["times_real_time"] = round(rate, 1)
        return rate

    return measure
