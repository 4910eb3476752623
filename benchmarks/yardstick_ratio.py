"""The closed loop against the same algorithm by hand in C: in lock-step, and how much slower."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import cache
from pathlib import Path
from statistics import median
from typing import Final

import numpy as np

from drivegate.drives.running import run_scenario
from drivegate_lab.bench.measurements import run_correctness
from drivegate_lab.bench.workbench import (
    Correctness,
    NotMeasured,
    Value,
    Workbench,
    interleaved,
    operating_scenario,
    ratio,
)
from drivegate_models.errors import InputError
from drivegate_models.loop.closed_loop import ClosedLoopRun
from drivegate_models.units import RADIANS_PER_RPM
from yardstick import FOLDER, RECORD, SOURCE, Yardstick, YardstickRun, build_yardstick

SIMULATED: Final = 8.0
"""Simulated time of a run (s): long, so that loops are compared and not their preparation, but too short for a stretch
whose ripple is followed, which the yardstick does not do."""
TURNS: Final = 3
"""Turns of loop and yardstick for each round of other measurements."""
LOCK_STEP_TOLERANCE: Final = 1e-9
"""Difference up to which both did the same, as `difference` measures it."""

_COMPARED: Final = {
    "speed": ("speed_rpm", RADIANS_PER_RPM),
    "current_reference": ("current_reference_a", 1.0),
    "current_sum": ("current_sum_a", 1.0),
}


def yardstick_ratio(bench: Workbench, candidate: str, speed_rpm: int) -> Value:
    """Measure the closed loop against the yardstick in C, run by run in turns."""
    yardstick = compiled_yardstick(bench.scratch)
    controller = bench.controller(candidate)
    scenario = operating_scenario(speed_rpm, "ideal", bench.simulated(SIMULATED))
    prepared = yardstick.prepared(scenario, None if candidate == "initial" else controller)
    own = run_scenario(scenario, controller, trace_every=1)
    apart = difference(own, prepared(recorded=True))
    works = (lambda: run_scenario(scenario, controller), prepared)
    is_right = run_correctness(scenario, own).valid
    return ratio_in_turns(works, scenario.duration_s, TURNS * bench.rounds, apart, is_right=is_right)


def ratio_in_turns(
    works: tuple[Callable[[], object], Callable[[], object]],
    simulated: float,
    rounds: int,
    apart: float,
    *,
    is_right: bool = True,
) -> Value:
    """Time loop and yardstick, each of a simulated time (s), in turns; both must have been in step."""
    ours, theirs = interleaved(works, time.process_time, rounds)
    rates = [simulated / median(times) for times in (ours, theirs)]
    measured = f"{rates[0]:.0f} against {rates[1]:.0f} × real time, in step within {apart:.0e}"
    return ratio(ours, theirs, Correctness(is_right and apart <= LOCK_STEP_TOLERANCE, measured))


def compiled_yardstick(scratch: Path) -> Yardstick:
    """Compile the yardstick, once in a folder."""
    return Yardstick(compiled_library(scratch, SOURCE))


@cache
def compiled_library(scratch: Path, name: str) -> Path:
    """Compile a source of the yardstick's folder, once in a folder."""
    try:
        return build_yardstick(FOLDER, scratch, name)
    except InputError as error:
        raise NotMeasured(str(error)) from error


def difference(ours: ClosedLoopRun, theirs: YardstickRun) -> float:
    """Return the greatest difference of two runs, relative to the greatest value of each signal, and of integrals."""
    differences = []
    for signal, (column, unit) in _COMPARED.items():
        own = ours.trace[column]
        other = theirs.rows[:, RECORD.index(signal)] / unit
        differences.append(np.abs(own - other).max() / np.abs(own).max())
    totals = np.abs(ours.totals - theirs.totals) / np.maximum(np.abs(ours.totals), 1e-9)
    return float(max(*differences, totals.max()))
