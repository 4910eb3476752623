"""Steps of a controller on signals that are given, not fed back: no plant is in this loop."""

from __future__ import annotations

from math import inf, isfinite, nan
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.calling import call_step
from drivegate_models.compilation.kernels import unallocating
from drivegate_models.contract.outer_loop.records import COMMAND, SENSE

COMPLETED: Final = 0
"""Status: all steps were made."""
STOPPED: Final = 1
"""Status: the controller's bridge asked to stop; it knows why."""
NOT_FINITE: Final = 2
"""Status: the controller's command was not finite."""

SIGNALS: Final = ("speed_reference", "speed", "current_magnitude_sum", "half_supply_voltage")
"""Columns of the signals, fields of a Sense; the phase currents share the sum alike, with changing signs."""


@unallocating
def _make_steps(
    sense: NDArray[Any],
    command: NDArray[Any],
    currents: NDArray[np.float64],
    phases: int,
    progress: NDArray[np.int64],
    addresses: NDArray[np.int64],
    control_period: float,
    signals: NDArray[np.float64],
    angles: NDArray[np.float64],
    begin: int,
    end: int,
) -> tuple[int, int]:
    """Make the steps from `begin` up to `end`; return the status and the number of the step that it ended at."""
    for k in range(begin, end):
        sense[0].time = k * control_period
        sense[0].speed_reference = signals[k, 0]
        sense[0].speed = signals[k, 1]
        sense[0].current_magnitude_sum = signals[k, 2]
        sense[0].half_supply_voltage = signals[k, 3]
        share = signals[k, 2] / phases
        for phase in range(phases):
            currents[phase] = share
            share = -share
        command[0].current_reference = nan
        command[0].advance_angle = nan
        command[0].input_power = nan
        progress[0] = k + 1
        call_step(addresses[0], addresses[1], addresses[2], addresses[3])
        if command[0].struct_size < 0:
            return STOPPED, k
        angle = command[0].advance_angle
        finite = isfinite(angle) and isfinite(command[0].current_reference)
        if not finite or abs(command[0].input_power) == inf:
            return NOT_FINITE, k
        angles[k] = angle
    return COMPLETED, end


class ScriptedSteps:
    """A controller, already reset, that is stepped through given signals.

    Parameters
    ----------
    signals : ndarray, shape (n, len(SIGNALS))
        What the controller is told, one row for each step, in SI units.
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
        Advance angle that the controller asked for in each step made (rad).
    sense : ndarray of SENSE, shape (1,)
        What the controller was told last.
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
        self.angles: NDArray[np.float64] = np.full(len(signals), nan)
        self.sense: NDArray[Any] = np.zeros(1, SENSE) if sense is None else sense
        self.currents: NDArray[np.float64] = np.zeros(phases) if sensed_currents is None else sensed_currents
        self.command: NDArray[Any] = np.zeros(1, COMMAND)
        self.sense[0]["struct_size"] = SENSE.itemsize
        self.sense[0]["phase_count"] = phases
        self.sense[0]["phase_currents"] = self.currents.ctypes.data
        self.command[0]["struct_size"] = COMMAND.itemsize
        self._signals = np.ascontiguousarray(signals, np.float64)
        self._phases = phases
        self._control_period = control_period
        self._progress = np.zeros(1, np.int64) if progress is None else progress
        self._addresses = np.array(
            [step_address, state_address, self.sense.ctypes.data, self.command.ctypes.data], np.int64
        )

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
            self.sense,
            self.command,
            self.currents,
            self._phases,
            self._progress,
            self._addresses,
            self._control_period,
            self._signals,
            self.angles,
            begin,
            len(self._signals) if end is None else end,
        )
        return int(status), int(step)
