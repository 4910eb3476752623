"""How fast steady states and the oracle are on one processor."""

from __future__ import annotations

import time
from math import degrees, radians
from typing import Final

from drivegate.drives.kinds import DEFAULT_DRIVE, DEFAULT_KIND
from drivegate.studies.bench.measurement import Correctness, Value, duration, rate, timed
from drivegate.studies.bench.workbench import Workbench

POINTS: Final = 20_000
"""Number of steady states, of which each has its own speed, angle and current reference."""
LEAST_CERTIFIED: Final = 0.98
"""Share of them that has to be certified periodic."""
CLOSING: Final = 1e-9
"""Residual of the power of a point, over its input power, up to which it is right."""

# How closely the edge is located.
_EDGE = radians(2e-4)


def steady_rate(bench: Workbench, band: float, drive_name: str = DEFAULT_DRIVE) -> Value:
    """Measure the solution of steady states of a drive."""
    import numpy as np

    from drivegate_cases.drive.drive_document import load_drive
    from drivegate_models.steady.grid import POINT_COLUMNS, solve_points
    from drivegate_models.steady.plant import make_phases
    from drivegate_models.steady.steady_state import KEPT_TIME

    # Without core loss, which floating phases take from the shaft, powers add up from what a point shows.
    drive = load_drive(drive_name).plant()._replace(hysteresis_band=band, core_loss_conductance=0.0)
    work, slices = make_phases(drive, KEPT_TIME), make_phases(drive)
    count = POINTS // 10 if bench.quick else POINTS
    places = np.arange(count, dtype=np.float64)
    # Three lengths without a common divisor: no two points are alike.
    speeds = 60.0 + 100.0 * (places % 97) / 97.0
    references = 5.0 + 20.0 * (places % 89) / 89.0
    advances = 1.2 * (places % 83) / 83.0
    values = np.empty((count, len(POINT_COLUMNS)))

    def solve() -> None:
        solve_points(drive, work, slices, drive.half_supply_voltage, speeds, advances, references, values)

    solve()
    columns = dict(zip(POINT_COLUMNS, values.T, strict=True))
    certified = float(columns["certified"].mean())
    # What goes in and is neither shaft power nor loss is what the solution got wrong.
    exact = columns["certified"] > 0.0
    shaft = columns["torque_mean_nm"] * speeds
    lost = columns["input_power_w"] - shaft - columns["copper_loss_w"]
    residual = float(np.abs(lost[exact] / np.maximum(np.abs(columns["exchanged_power_w"][exact]), 1.0)).max())
    right = certified >= LEAST_CERTIFIED and residual <= CLOSING
    correctness = Correctness(
        right, f"{100.0 * certified:.1f} % certified periodic, power within {residual:.0e}"
    )
    return rate(count, timed(solve, time.process_time, bench.rounds), correctness)


def oracle_time(bench: Workbench, speed_rpm: float, torque: float) -> Value:
    """Measure how long the angle of least Σ|i| takes at one point."""
    from drivegate_cases.drive.drive_document import load_drive
    from drivegate_models.units import RADIANS_PER_RPM

    oracle, drive = DEFAULT_KIND.oracle(), load_drive(DEFAULT_DRIVE).plant()
    speed = speed_rpm * RADIANS_PER_RPM
    best = oracle.least_current_sum(drive, speed, torque)
    there = oracle.point_at_torque(drive, speed, best.advance, torque)
    edge = oracle.feasible_edge(drive, speed, torque)
    right = (
        best.advance >= edge - _EDGE
        and abs(there.torque - torque) <= 1e-6 * torque
        and abs(there.current_sum - best.current_sum) <= 1e-6 * best.current_sum
    )
    measured = f"{degrees(best.advance):.2f}° gives {there.torque:.4f} N·m with {best.current_sum:.3f} A"
    times = timed(lambda: oracle.least_current_sum(drive, speed, torque), time.process_time, bench.rounds)
    return duration(times, Correctness(right, measured), 1e3)
