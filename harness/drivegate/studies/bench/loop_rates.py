"""How fast the closed loop is: simulated seconds a second, by candidate, speed and sensors."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from statistics import median
from typing import TYPE_CHECKING, Final

from drivegate.drives.running import run_scenario
from drivegate.runs.scenario import RADIANS_PER_RPM
from drivegate.studies.bench.measurement import Checked, Value, interleaved, rate, timed
from drivegate.studies.bench.workbench import Workbench, operating_scenario
from drivegate.studies.bench.yardstick import RECORD
from drivegate_models.loop import observation

if TYPE_CHECKING:
    from drivegate_cases.scenario.scenario import Scenario
    from drivegate_models.loop.closed_loop import ClosedLoopRun

CANDIDATES: Final = ("reference", "numba", "c", "python", "exec")
SPEEDS_RPM: Final = (500, 1000, 1500, 2000)
SENSORS: Final = ("ideal", "mcs96")
SIMULATED: Final = {"reference": 4.0, "initial": 4.0, "numba": 4.0, "c": 4.0, "python": 2.0, "exec": 1.0}
"""Simulated time of each run (s)."""

TOLERANCE_RPM: Final = {"ideal": 5.0, "mcs96": 10.0}
"""How far the true speed may end from its reference (rpm)."""
ENERGY_TOLERANCE: Final = 1e-9
"""Residual of the energy in a control period, over its throughput, up to which a run is right."""
LOCK_STEP_TOLERANCE: Final = 1e-9
"""Difference from the yardstick up to which both did the same, relative to the greatest value of each signal."""

YARDSTICK_SIMULATED: Final = 8.0
"""Simulated time of a run against the yardstick (s): long, so that loops are compared and not their preparation, but
too short for a stretch whose ripple is followed, which the yardstick does not do."""
TURNS: Final = 3
"""Turns of loop and yardstick for each round of other measurements."""

_COMPARED: Final = {
    "speed": "speed_rpm",
    "current_reference": "current_reference_a",
    "current_sum": "current_sum_a",
}


def checked_run(scenario: Scenario, run: ClosedLoopRun) -> Checked:
    """Tell whether a run came to what it should."""
    speed = float(run.run[observation.RUN_SPEED_FINAL]) / RADIANS_PER_RPM
    wanted = float(scenario.speed_rpm[-1][1])
    residual = float(run.run[observation.RUN_EXCHANGE_ERROR])
    right = abs(speed - wanted) <= TOLERANCE_RPM[scenario.sensors.kind] and residual <= ENERGY_TOLERANCE
    return Checked(right, f"ends at {speed:.1f} rpm, energy within {residual:.0e}")


def loop_rate(bench: Workbench, candidate: str, speed_rpm: int, sensors: str) -> Value:
    """Measure the closed loop with one candidate at one speed."""
    seconds = bench.simulated(SIMULATED[candidate])
    scenario = operating_scenario(speed_rpm, sensors, seconds)
    clock = time.perf_counter if candidate == "exec" else time.process_time
    with _one_processor():
        controller = bench.controller(candidate)
        checked = checked_run(scenario, run_scenario(scenario, controller))
        times = timed(lambda: run_scenario(scenario, controller), clock, bench.rounds)
    return rate(seconds, times, checked)


@contextmanager
def _one_processor() -> Iterator[None]:
    """Keep this process and those that it starts on one processor, where the system can do so.

    Two processes that take turns are woken from the sleep of an idle processor otherwise, as they are not in a gate,
    whose workers keep all processors busy.
    """
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    allowed = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(allowed)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, allowed)


def yardstick_ratio(bench: Workbench, candidate: str, speed_rpm: int) -> Value:
    """Measure the closed loop against the yardstick in C, run by run in turns."""
    import numpy as np

    yardstick = bench.yardstick()
    controller = bench.controller(candidate)
    scenario = operating_scenario(speed_rpm, "ideal", bench.simulated(YARDSTICK_SIMULATED))
    prepared = yardstick.prepared(scenario, None if candidate == "initial" else controller)
    own = run_scenario(scenario, controller, trace_every=1)
    other = prepared(recorded=True)
    signals = own.trace[:, [observation.TRACE_COLUMNS.index(name) for name in _COMPARED.values()]]
    units = [RADIANS_PER_RPM if name == "speed" else 1.0 for name in _COMPARED]
    recorded = other.rows[:, [RECORD.index(name) for name in _COMPARED]] / units
    differences = np.abs(recorded - signals).max(axis=0) / np.abs(signals).max(axis=0)
    totals = np.abs(other.totals - own.totals) / np.maximum(np.abs(own.totals), 1e-9)
    worst = float(max(differences.max(), totals.max()))
    together = checked_run(scenario, own).valid and worst <= LOCK_STEP_TOLERANCE
    ours, theirs = interleaved(
        (lambda: run_scenario(scenario, controller), prepared), time.process_time, TURNS * bench.rounds
    )
    speeds = [scenario.duration_s / median(times) for times in (ours, theirs)]
    told = f"{speeds[0]:.0f} against {speeds[1]:.0f} × real time, in step within {worst:.0e}"
    # What else runs slows both runs of a turn; the best of each may be from different turns.
    ratio = median(own_time / their_time for own_time, their_time in zip(ours, theirs, strict=True))
    return Value(ratio, ratio, len(ours), Checked(together, told))
