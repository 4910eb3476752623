"""How fast the closed loop is: simulated seconds a second, by candidate, speed and sensors."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

from drivegate.drives.kinds import DEFAULT_DRIVE
from drivegate.drives.running import run_scenario
from drivegate.studies.bench.measurement import Correctness, Value, rate, timed
from drivegate.studies.bench.workbench import Workbench, operating_scenario
from drivegate_models.units import RADIANS_PER_RPM

if TYPE_CHECKING:
    from drivegate_cases.scenario.scenario import Scenario
    from drivegate_models.loop.closed_loop import ClosedLoopRun

CANDIDATES: Final = ("reference", "numba", "c", "python", "exec")
SPEEDS_RPM: Final = (500, 1000, 1500, 2000)
SENSORS: Final = ("ideal", "mcs96")
SIMULATED: Final = {"reference": 4.0, "initial": 4.0, "numba": 4.0, "c": 4.0, "python": 2.0, "exec": 1.0}
"""Simulated time of each run (s)."""

TOLERANCE_RPM: Final = {"ideal": 5.0, "mcs96": 10.0}
"""How far the true speed may end from the speed reference (rpm)."""
ENERGY_TOLERANCE: Final = 1e-9
"""Residual of the energy in a control period, over its throughput, up to which a run is right."""


def run_correctness(scenario: Scenario, run: ClosedLoopRun) -> Correctness:
    """Compare a run with its expected result."""
    speed = run.observed.speed_final / RADIANS_PER_RPM
    speed_reference = float(scenario.speed_rpm[-1][1])
    residual = run.observed.exchange_error
    right = (
        abs(speed - speed_reference) <= TOLERANCE_RPM[scenario.sensors.kind] and residual <= ENERGY_TOLERANCE
    )
    return Correctness(right, f"ends at {speed:.1f} rpm, energy within {residual:.0e}")


def loop_rate(
    bench: Workbench, candidate: str, speed_rpm: int, sensors: str, drive: str = DEFAULT_DRIVE
) -> Value:
    """Measure the closed loop of a drive with one candidate at one speed."""
    seconds = bench.simulated(SIMULATED[candidate])
    scenario = operating_scenario(speed_rpm, sensors, seconds, drive)
    clock = time.perf_counter if candidate == "exec" else time.process_time
    with _one_processor():
        controller = bench.controller(candidate)
        correctness = run_correctness(scenario, run_scenario(scenario, controller))
        times = timed(lambda: run_scenario(scenario, controller), clock, bench.rounds)
    return rate(seconds, times, correctness)


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
