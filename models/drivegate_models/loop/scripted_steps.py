"""Steps of a controller on signals that are given, not fed back: no plant is in this loop."""

from __future__ import annotations

from math import nan
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import unallocating
from drivegate_models.loop.exchange import COMPLETED, Exchange, make_exchange, step_controller

SIGNALS: Final = ("speed_reference", "speed", "current_magnitude_sum", "half_supply_voltage")
"""Columns of the signals, fields of a Sense; the phase currents share the sum alike, with changing signs."""


@unallocating
def _make_steps(
    exchange: Exchange,
    phases: int,
    control_period: float,
    signals: NDArray[np.float64],
    angles: NDArray[np.float64],
    begin: int,
    end: int,
) -> tuple[int, int]:
    """Make the steps from `begin` up to `end`; return the status and the number of the step that it ended at."""
    sense = exchange.sense
    for k in range(begin, end):
        sense[0].time = k * control_period
        sense[0].speed_reference = signals[k, 0]
        sense[0].speed = signals[k, 1]
        sense[0].current_magnitude_sum = signals[k, 2]
        sense[0].half_supply_voltage = signals[k, 3]
        share = signals[k, 2] / phases
        for phase in range(phases):
            exchange.sensed_currents[phase] = share
            share = -share
        status = step_controller(exchange, k)
        if status != COMPLETED:
            return status, k
        angles[k] = exchange.command[0].advance_angle
    return COMPLETED, end


class ScriptedSteps:
    """A controller, already reset, that is stepped through given signals.

    Parameters
    ----------
    signals : ndarray, shape (n, len(SIGNALS))
        What the controller senses, one row for each step, in SI units.
    step_address, state_address : int
        Addresses of the controller's step function and of its state.
    phases : int
        Number of phases.
    control_period : float
        Time between two steps (s).
    sense : ndarray of SENSE, shape (1,), optional
        The record to hand to the controller, where another process is to see it.
    sensed_currents : ndarray, shape (m,) or longer, optional
        Where its phase currents belong (A).
    progress : ndarray of int64, shape (1,), optional
        Receives the number of steps begun.

    Attributes
    ----------
    angles : ndarray, shape (n,)
        Advance angle that the controller answered with in each step made (rad).
    sense : ndarray of SENSE, shape (1,)
        What the controller sensed last.
    currents : ndarray
        Its phase currents (A).
    command : ndarray of COMMAND, shape (1,)
        What it answered last.
    """

    def __init__(
        self,
        signals: NDArray[np.float64],
        *,
        step_address: int,
        state_address: int,
        phases: int,
        control_period: float,
        sense: NDArray[Any] | None = None,
        sensed_currents: NDArray[np.float64] | None = None,
        progress: NDArray[np.int64] | None = None,
    ) -> None:
        self._exchange = make_exchange(
            phases,
            step_address=step_address,
            state_address=state_address,
            sense=sense,
            sensed_currents=sensed_currents,
            progress=progress,
        )
        self.angles: NDArray[np.float64] = np.full(len(signals), nan)
        self.sense: NDArray[Any] = self._exchange.sense
        self.currents: NDArray[np.float64] = self._exchange.sensed_currents
        self.command: NDArray[Any] = self._exchange.command
        self._signals = np.ascontiguousarray(signals, np.float64)
        self._phases = phases
        self._control_period = control_period

    def advance(self, begin: int = 0, end: int | None = None) -> tuple[int, int]:
        """Make steps, which have to follow on those made before.

        Parameters
        ----------
        begin : int
            First step.
        end : int, optional
            Step to stop before; by default all are made.

        Returns
        -------
        status : int
            `COMPLETED`, `STOPPED` or `NOT_FINITE`.
        step : int
            The step that it ended at, `end` when all were made.
        """
        status, step = _make_steps(
            self._exchange,
            self._phases,
            self._control_period,
            self._signals,
            self.angles,
            begin,
            len(self._signals) if end is None else end,
        )
        return int(status), int(step)
