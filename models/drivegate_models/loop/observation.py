"""The observations that the closed loop stores for a run.

There is one record for the whole run, one for each observed window, and three numbers for each averaging time in it.
The kernels write numpy records; readers of a completed run get the same fields as named tuples.
"""

from __future__ import annotations

from math import inf
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

MEAN_TIME: Final = 0.1
"""Default averaging time of the current sum (s)."""

RIPPLE_TIME: Final = 1.0
"""Time at a window's end in which the torque's extremes are observed (s)."""


class RunObservation(NamedTuple):
    """Observations over a whole run."""

    steps: float
    """Control periods done."""
    reference_lowest: float
    """Minimum current reference in the candidate's commands, before clamping (A)."""
    reference_highest: float
    """Maximum current reference, before clamping (A)."""
    angle_lowest: float
    """Minimum advance angle in the candidate's commands, before clamping (rad)."""
    angle_highest: float
    """Maximum advance angle, before clamping (rad)."""
    angle_below_base: float
    """Maximum magnitude of the advance angle in steps whose measured speed was below base speed (rad)."""
    steps_below_base: float
    """Number of steps whose measured speed was below base speed."""
    power_estimates: float
    """Number of input power estimates."""
    power_error: float
    """Maximum difference of an estimate from measured supply voltage times measured current sum, or from the mean of
    that product over the window that the candidate declares (W)."""
    power_error_relative: float
    """The same difference relative to that product, or to 1 W if the product is smaller (1)."""
    exchange_error: float
    """Maximum difference of net supply energy, `EXCHANGED` - 2 `RETURNED`, from the energy consumed and stored, over
    the energy exchanged or stored (1)."""
    kinetic_residual: float
    """Error of the kinetic energy by the constant speed within each period (J): the sum of ``J`` times the change of
    speed times the difference of its mean from the constant speed."""
    shaft_energy: float
    """Sum of speed times electromagnetic impulse (J)."""
    input_energy: float
    """Net energy taken from the supply, core and switching losses included (J)."""
    first_below_base: float
    """Time of the step of `angle_below_base` (s)."""
    speed_final: float
    """Speed at the end (rad/s)."""
    neutral_current: float
    """Maximum |sum of the phase currents| over the sum of their magnitudes, at the end of a period (1)."""
    unequal_halves: float
    """Maximum difference of the energies from the half-sources in a period, over the energy exchanged (1)."""


class WindowObservation(NamedTuple):
    """Observations in one window of a run."""

    steps: float
    """Control periods in the window."""
    speed_error: float
    """Maximum magnitude of the true speed error (rad/s)."""
    angle_lowest: float
    """Minimum advance angle, as applied (rad)."""
    angle_highest: float
    """Maximum advance angle, as applied (rad)."""
    current_sum: float
    """Mean of the current sum (A)."""
    torque: float
    """Mean electromagnetic torque (N m)."""
    input_power: float
    """Mean net input power, all losses included (W)."""
    exchanged_power: float
    """Mean power exchanged with the half-sources (W)."""
    angle: float
    """Mean advance angle (rad)."""
    reference: float
    """Mean current reference (A), as applied."""
    speed: float
    """Mean speed (rad/s)."""
    peak: float
    """Maximum magnitude of a phase current (A)."""
    ripple: float
    """Torque ripple, peak to peak over mean, of the worst electrical period in the window's last `RIPPLE_TIME` (1)."""
    ripple_one_sided: float
    """Maximum deviation from the mean over the mean, of the worst electrical period there (1)."""
    torque_lowest: float
    """Minimum torque of the electrical periods there (N m); inf if there was none."""
    means: NDArray[np.float64]
    """Mean of the current sum (A), root mean square of the current reference (A) and mean advance angle (rad), both as
    applied, over each whole averaging time in the window, shape (n, 3)."""

    @property
    def current_sum_range(self) -> float:
        """Range of the means of the current sum (A); 0 without any."""
        return float(np.ptp(self.means[:, 0])) if len(self.means) else 0.0


TRACE_COLUMNS: Final = (
    "time_s",
    "speed_reference_rpm",
    "speed_rpm",
    "current_sum_a",
    "current_reference_a",
    "advance_deg",
    "torque_nm",
    "load_torque_nm",
    "input_power_w",
    "half_supply_v",
    "measured_speed_rpm",
    "current_peak_a",
    "torque_lowest_nm",
    "torque_highest_nm",
)
"""Columns of a trace, with their units; one record for each recorded control period.

The torque's extremes are NaN where no window observes its ripple.
"""


def _record_of(names: tuple[str, ...]) -> np.dtype[Any]:
    return np.dtype([(name, np.float64) for name in names])


RUN_RECORD: Final = _record_of(RunObservation._fields)
WINDOW_RECORD: Final = _record_of(WindowObservation._fields[:-1])
"""Record of `WindowObservation` but for its `means`; what is a mean of the window is a sum until the run has ended."""
TRACE_RECORD: Final = _record_of(TRACE_COLUMNS)

_MEANS = (
    "current_sum",
    "torque",
    "input_power",
    "exchanged_power",
    "angle",
    "reference",
    "speed",
)


def empty_run() -> NDArray[Any]:
    """Return the record of a run that has not begun, shape (1,) of RUN_RECORD."""
    run = np.zeros(1, RUN_RECORD)
    run["reference_lowest"] = run["angle_lowest"] = inf
    run["reference_highest"] = run["angle_highest"] = -inf
    return run


def empty_windows(count: int) -> NDArray[Any]:
    """Return the records of windows that have not begun, shape (count,) of WINDOW_RECORD."""
    windows = np.zeros(count, WINDOW_RECORD)
    windows["angle_lowest"] = windows["torque_lowest"] = inf
    windows["angle_highest"] = -inf
    return windows


def observed_run(run: NDArray[Any]) -> RunObservation:
    """Return the observations of a completed run from its record, shape (1,) of RUN_RECORD."""
    return RunObservation(*run[0].tolist())


def observed_windows(
    windows: NDArray[Any], blocks: NDArray[np.float64], starts: NDArray[np.int64], block: int
) -> tuple[WindowObservation, ...]:
    """Return the observations in the windows of a completed run, with means instead of sums.

    - `windows`, shape (w,) of WINDOW_RECORD.
    - `blocks`, shape (n, 3): sums of current sum (A), squared current reference (A²) and advance angle (rad) over each
      block of each window.
    - `starts`, shape (w,): first block of each window.
    - `block`: control periods in a block; one that has not ended has no means. `blocks` has the means afterwards.
    """
    observed = windows.copy()
    for name in _MEANS:
        observed[name] /= np.maximum(windows["steps"], 1.0)
    return tuple(
        WindowObservation._make((*row, _means(blocks[start : start + int(row[0]) // block], block)))
        for row, start in zip(observed.tolist(), starts, strict=True)
    )


def _means(sums: NDArray[np.float64], block: int) -> NDArray[np.float64]:
    """Make means of sums in their place, since a long run has many."""
    sums /= block
    np.sqrt(sums[:, 1], out=sums[:, 1])
    return sums
