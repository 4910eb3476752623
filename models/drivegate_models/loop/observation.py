"""What the closed loop keeps of a run: fixed numbers, whatever the run's length.

One record for the whole run, and one for each observed window of it. The kernels write records of numpy; whoever
reads a finished run gets the same fields as named tuples.
"""

from __future__ import annotations

from math import inf
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

MEAN_TIME: Final = 0.1
"""Length of the means of the current sum where none is given (s)."""

RIPPLE_TIME: Final = 1.0
"""Time at a window's end in which the torque's extremes are followed (s)."""


class RunObservation(NamedTuple):
    """What is observed over a whole run."""

    steps: float
    """Control periods done."""
    reference_lowest: float
    """Least current reference that the candidate answered with (A), before clamping."""
    reference_highest: float
    """Greatest (A)."""
    angle_lowest: float
    """Least advance angle that the candidate answered with (rad), before clamping."""
    angle_highest: float
    """Greatest (rad)."""
    angle_below_base: float
    """Greatest magnitude of the advance angle in steps whose Sense showed less than base speed (rad)."""
    steps_below_base: float
    """Number of those steps."""
    power_estimates: float
    """Number of input power estimates."""
    power_error: float
    """Greatest difference of an estimate from measured supply voltage times measured current sum, or from the mean
    of that product over the window that the candidate declares (W)."""
    power_error_relative: float
    """The same over that product, where it exceeds 1 W (1)."""
    exchange_error: float
    """Greatest difference of net supply energy, `EXCHANGED` - 2 `RETURNED`, from where it went, over the energy that
    was exchanged or stored."""
    kinetic_residual: float
    """Sum of ``J`` times the change of speed times how far its mean lies above the speed that was held, which is what
    holding the speed within a period leaves out of the kinetic energy (J)."""
    shaft_energy: float
    """Sum of speed times electromagnetic impulse (J)."""
    input_energy: float
    """Net energy taken from the supply, core and switching losses included (J)."""
    first_below_base: float
    """Time of the step of `angle_below_base` (s)."""
    speed_final: float
    """Speed at the end (rad/s)."""
    neutral_current: float
    """Greatest |sum of the phase currents| over the sum of their magnitudes, at the end of a period (1)."""
    unequal_halves: float
    """Greatest difference of the energies that a period takes from the half-sources, over what it exchanges (1)."""


class WindowObservation(NamedTuple):
    """What is observed in one window of a run."""

    steps: float
    """Control periods in the window."""
    speed_error: float
    """Greatest magnitude of the true speed error (rad/s)."""
    angle_lowest: float
    """Least advance angle (rad), as applied."""
    angle_highest: float
    """Greatest (rad)."""
    mean_lowest: float
    """Least mean of the current sum over the time of a mean (A)."""
    mean_highest: float
    """Greatest (A)."""
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
    """Greatest phase current (A)."""
    ripple: float
    """Torque ripple, peak to peak over mean, of the worst electrical period in the window's last `RIPPLE_TIME` (1)."""
    ripple_one_sided: float
    """Greatest deviation from the mean over the mean, of the worst electrical period there (1)."""
    torque_lowest: float
    """Least torque of the electrical periods there (N m); inf where there was none."""


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
)
"""Columns of a trace, in people's units; one record for each kept control period."""


def _record_of(names: tuple[str, ...]) -> np.dtype[Any]:
    return np.dtype([(name, np.float64) for name in names])


RUN_RECORD: Final = _record_of(RunObservation._fields)
"""Record of `RunObservation`."""
WINDOW_RECORD: Final = _record_of(WindowObservation._fields)
"""Record of `WindowObservation`; the means are sums until the run has ended."""
TRACE_RECORD: Final = _record_of(TRACE_COLUMNS)
"""Record of one kept control period."""

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
    """Make the record of a run that has not begun.

    Returns
    -------
    ndarray of RUN_RECORD, shape (1,)
        Nothing observed.
    """
    run = np.zeros(1, RUN_RECORD)
    run["reference_lowest"] = run["angle_lowest"] = inf
    run["reference_highest"] = run["angle_highest"] = -inf
    return run


def empty_windows(count: int) -> NDArray[Any]:
    """Make the records of windows that have not begun.

    Parameters
    ----------
    count : int
        Number of windows.

    Returns
    -------
    ndarray of WINDOW_RECORD, shape (count,)
        Nothing observed.
    """
    windows = np.zeros(count, WINDOW_RECORD)
    windows["angle_lowest"] = windows["mean_lowest"] = windows["torque_lowest"] = inf
    windows["angle_highest"] = windows["mean_highest"] = -inf
    return windows


def observed_run(run: NDArray[Any]) -> RunObservation:
    """Give what was observed over a finished run.

    Parameters
    ----------
    run : ndarray of RUN_RECORD, shape (1,)
        Its record.

    Returns
    -------
    RunObservation
        The same numbers.
    """
    return RunObservation(*run[0].tolist())


def observed_windows(windows: NDArray[Any]) -> tuple[WindowObservation, ...]:
    """Give what was observed in the windows of a finished run, sums turned into means.

    Parameters
    ----------
    windows : ndarray of WINDOW_RECORD, shape (w,)
        Their records.

    Returns
    -------
    tuple of WindowObservation
        One for each window.
    """
    means = windows.copy()
    for name in _MEANS:
        means[name] /= np.maximum(windows["steps"], 1.0)
    return tuple(WindowObservation(*row) for row in means.tolist())
