"""Steps of a controller on prescribed Senses: there is no plant and no feedback."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import unallocating
from drivegate_models.loop.exchange import COMPLETED, Exchange, step_controller

SCALARS: Final = ("time", "speed_reference", "speed", "current_magnitude_sum", "half_supply_voltage")
"""First columns of a row of a Sense (SI units); the phase currents are the columns after them."""


@unallocating
def make_steps(exchange: Exchange, senses: NDArray[np.float64]) -> tuple[int, int]:
    """Step a controller, already reset, through prescribed Senses.

    Parameters
    ----------
    exchange : Exchange
        Its Sense is overwritten; its `kept` receives the commands.
    senses : ndarray, shape (n, len(SCALARS) + m)
        One Sense per row, in SI units.

    Returns
    -------
    status : int
        `COMPLETED`, `STOPPED` or `NOT_FINITE`.
    answered : int
        Number of completed steps, and so the number of the step with another status.
    """
    sense = exchange.sense
    for k in range(senses.shape[0]):
        row = senses[k]
        sense[0].time = row[0]
        sense[0].speed_reference = row[1]
        sense[0].speed = row[2]
        sense[0].current_magnitude_sum = row[3]
        sense[0].half_supply_voltage = row[4]
        for phase in range(row.size - 5):
            exchange.sensed_currents[phase] = row[5 + phase]
        status = step_controller(exchange, k)
        if status != COMPLETED:
            return status, k
    return COMPLETED, senses.shape[0]


def senses_of(signals: NDArray[np.float64], phases: int, control_period: float) -> NDArray[np.float64]:
    """Return rows of Senses for a script's signals.

    Parameters
    ----------
    signals : ndarray, shape (n, 4)
        Speed reference and speed (rad/s), current magnitude sum (A) and mean voltage of the half-sources (V).
    phases : int
        Number of phases m.
    control_period : float
        Time between two steps (s).

    Returns
    -------
    ndarray, shape (n, len(SCALARS) + m)
        The rows. The phase currents share the sum equally, with alternating signs.
    """
    times = np.arange(len(signals)) * control_period
    shares = signals[:, 2:3] / phases * np.where(np.arange(phases) % 2, -1.0, 1.0)
    return np.column_stack([times, signals, shares])
