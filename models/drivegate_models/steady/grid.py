"""Many steady states in one compiled loop; a map of a million points needs seconds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import kernel
from drivegate_models.steady.plant import AnyDrive, AnyPhases
from drivegate_models.steady.steady_state import solve_steady_state

POINT_COLUMNS = (
    "torque_mean_nm",
    "torque_ripple_percent",
    "current_sum_a",
    "exchanged_power_w",
    "input_power_w",
    "copper_loss_w",
    "core_loss_w",
    "current_peak_a",
    "certified",
)
"""Columns of `solve_points`, one row per point."""
_NO_TORQUE = 1e-9


@kernel
def solve_points(
    drive: AnyDrive,
    work: AnyPhases,
    slices: AnyPhases,
    voltage: float,
    speeds: NDArray[np.float64],
    advances: NDArray[np.float64],
    references: NDArray[np.float64],
    values: NDArray[np.float64],
) -> None:
    """Solve the steady state at each of many points.

    `drive`, `work`, `slices`, `voltage`: arguments of `drivegate_models.steady.steady_state.solve_steady_state`.
    `speeds`, `advances`, `references`, shape (n,): shaft speeds (rad/s), above 0, advance angles (rad electrical) and
    current references (A). `values`, shape (n, len(POINT_COLUMNS)): receives `POINT_COLUMNS`. The ripple is peak to
    peak over the mean's magnitude (%), NaN without torque. The input power includes core loss and switching.
    `certified` is 1 for a periodic state, 0 for means over many cycles.
    """
    for place in range(len(speeds)):
        state = solve_steady_state(
            drive, work, slices, speeds[place], voltage, references[place], advances[place]
        )
        mean = abs(state.torque)
        ripple = np.nan
        if mean > _NO_TORQUE:
            ripple = 100.0 * (state.torque_highest - state.torque_lowest) / mean
        values[place, 0] = state.torque
        values[place, 1] = ripple
        values[place, 2] = state.current_sum
        values[place, 3] = state.exchanged_power
        values[place, 4] = state.source_power + state.core_source_power + state.switching_loss
        values[place, 5] = state.copper_loss
        values[place, 6] = state.core_loss
        values[place, 7] = state.current_peak
        values[place, 8] = state.certified
