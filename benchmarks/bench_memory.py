"""Memory of a run without a trace, which does not grow with its length."""

import tracemalloc
from collections.abc import Callable
from typing import Any

from drivegate.candidates.controller import Controller
from drivegate.runs.scenario import run_scenario
from drivegate_cases.scenario.scenario import Scenario


def _peak(scenario: Scenario, subject: Controller) -> int:
    tracemalloc.start()
    run_scenario(scenario, subject)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return peak


def test_memory_does_not_grow(
    benchmark: Any, published_point: Scenario, controller: Callable[[str], Controller]
) -> None:
    subject = controller("reference")
    run_scenario(published_point, subject)
    short = _peak(published_point, subject)
    long = benchmark.pedantic(_peak, args=(published_point.replaced(duration_s=80.0), subject), rounds=1)
    benchmark.extra_info["bytes_4_s"] = short
    benchmark.extra_info["bytes_80_s"] = long
    assert long <= short + 4096, f"{short} bytes for 4 s, but {long} bytes for 80 s"
