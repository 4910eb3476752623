"""How much memory a run takes, and that it does not grow with the run's length."""

from __future__ import annotations

import tracemalloc
from typing import Final

from drivegate.drives.running import run_scenario
from drivegate.studies.bench.measurement import Correctness, Value
from drivegate.studies.bench.workbench import Workbench, operating_scenario

GROWTH: Final = 4096
"""Bytes that a run of twenty times the length may take more, for what the interpreter itself counts."""
_SHORT, _LONG = 4.0, 80.0


def run_memory(bench: Workbench) -> Value:
    """Measure the memory of a run without a trace."""
    controller = bench.controller("reference")
    peaks = []
    for seconds in (_SHORT, _SHORT, _LONG):
        scenario = operating_scenario(1500, "ideal", seconds)
        tracemalloc.start()
        try:
            run_scenario(scenario, controller)
            peaks.append(tracemalloc.get_traced_memory()[1])
        finally:
            tracemalloc.stop()
    _, short, long = peaks
    correctness = Correctness(long <= short + GROWTH, f"a run of {_LONG:g} s takes {long - short} bytes more")
    return Value(short / 1024.0, short / 1024.0, 1, correctness)
