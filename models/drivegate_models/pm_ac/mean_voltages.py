"""The means of the terminals' voltages that a drive may sense, and the filter that they may pass.

A filter of one pole with the time constant ``tau`` follows the mean ``m`` of each control period by
``dy/dt = (m - y) / tau``, which is solved exactly: ``y = m + (y - m) exp(-T / tau)`` after a period ``T``. The ripple
of the switching within a period does not pass.
"""

from __future__ import annotations

from math import nan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.loop.exchange import Exchange
from drivegate_models.pm_ac.decay import decay_of


class MeanVoltages(NamedTuple):
    """Sensor of the means of the terminals' voltages, and its state."""

    is_sensed: bool
    """True if the controller sees them."""
    decay: float
    """Share of a deviation that the filter leaves after a control period (1); 0 without a filter."""
    shown: NDArray[np.float64]
    """Output, shape (3,) (V); NaN before the first one."""


def no_mean_voltages() -> MeanVoltages:
    """Return that the drive does not sense them."""
    return MeanVoltages(False, 0.0, np.full(3, nan))


def sensed_mean_voltages(control_period: float, filter_time: float = 0.0) -> MeanVoltages:
    """Return the sensor for a control period (s) and the time constant of its filter, at least that (s); 0 for none."""
    decay = decay_of(control_period / filter_time) if filter_time > 0.0 else 0.0
    return MeanVoltages(True, decay, np.full(3, nan))


def unused_mean_voltages(voltages: MeanVoltages) -> MeanVoltages:
    """Return a sensor with a state of its own, so that a run can be repeated."""
    return voltages._replace(shown=np.full(3, nan))


@inlined
def show_mean_voltages(voltages: MeanVoltages, exchange: Exchange) -> None:
    """Write the output into the Sense. It begins with the voltages of the first step, as for ever before."""
    if not voltages.is_sensed:
        return
    for leg in range(3):
        if voltages.shown[leg] != voltages.shown[leg]:
            voltages.shown[leg] = exchange.sense[0].phase_voltages[leg]
        exchange.sense[0].mean_voltages[leg] = voltages.shown[leg]


@inlined
def follow_mean_voltages(voltages: MeanVoltages, volt_seconds: NDArray[np.float64], length: float) -> None:
    """Follow the means over a control period (s), and begin the integrals (V s) of the next one.

    `volt_seconds`, shape (3,): integrals over the period, reset; shape (0,) where nothing is sensed.
    """
    for leg in range(volt_seconds.size):
        mean = volt_seconds[leg] / length
        voltages.shown[leg] = mean + voltages.decay * (voltages.shown[leg] - mean)
        volt_seconds[leg] = 0.0
