"""Steady states: points a second on one core, over speeds, angles and current references."""

import time
from typing import Any

import numba
import pytest

from drivegate_cases.motor.motor import load_motor
from drivegate_models.half_bridge.plant.drive import Drive
from drivegate_models.half_bridge.plant.phases import Phases, make_phases
from drivegate_models.half_bridge.steady.steady_state import KEPT_TIME, solve_steady_state

# One core's own time, whatever else the machine does.
pytestmark = pytest.mark.benchmark(timer=time.process_time)

POINTS = 20_000
BAR = 50_000.0


@numba.njit
def _sweep(drive: Drive, work: Phases, slices: Phases, points: int) -> int:
    certified = 0
    for k in range(points):
        speed = 60.0 + 100.0 * (k % 97) / 97.0
        reference = 5.0 + 20.0 * (k % 89) / 89.0
        advance = 1.2 * (k % 83) / 83.0
        certified += solve_steady_state(
            drive, work, slices, speed, drive.half_supply_voltage, reference, advance
        ).certified
    return certified


@pytest.mark.parametrize("band", [0.25, 0.0])
def test_steady_state_points(benchmark: Any, band: float) -> None:
    drive = load_motor("paper-5-phase").drive()._replace(hysteresis_band=band)
    work, slices = make_phases(drive, KEPT_TIME), make_phases(drive)
    certified = _sweep(drive, work, slices, POINTS)
    assert certified > 0.98 * POINTS, f"only {certified} of {POINTS} states are certified periodic"
    benchmark.pedantic(_sweep, args=(drive, work, slices, POINTS), rounds=5)
    rate = POINTS / float(benchmark.stats.stats.min)
    benchmark.extra_info["points_a_second"] = round(rate)
    assert rate >= BAR, f"{rate:.0f} points a second, below {BAR:.0f}"
