"""Keeping every step of a controller as sensed and answered, and giving another controller the same to sense.

A recorder stands between the closed loop and a controller: it passes each step on and writes a row of exact
numbers. Its memory is one block of rows; a full one is handed to a function that empties it.
"""

from __future__ import annotations

from functools import cache
from math import nan
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.calling import call_step, double_at
from drivegate_models.compilation.kernels import KEEPS_CACHE, inlined, unallocating
from drivegate_models.contract.outer_loop.records import COMMAND, SENSE
from drivegate_models.loop.exchange import COMPLETED, STOPPED, Exchange, make_exchange, step_controller

SCALARS: Final = ("time", "speed_reference", "speed", "current_magnitude_sum", "half_supply_voltage")
"""First columns of a row: the Sense but for its phase currents, in SI units."""

OUTPUTS: Final = ("current_reference", "advance_angle", "input_power")
"""The columns after them: the Command. The phase currents are the last columns."""

MOST_PHASES: Final = 64
"""Phase currents that a row has room for."""

BLOCK_ROWS: Final = 1024
"""Rows that a recorder holds."""

DIFFERS: Final = 3
"""Status, besides those of `exchange`: an answer differs from the recorded one."""

_FIRST_OUTPUT = len(SCALARS)
_FIRST_CURRENT = len(SCALARS) + len(OUTPUTS)

RECORDER: Final = np.dtype(
    [
        ("step_address", np.int64),
        ("state_address", np.int64),
        ("empty_address", np.int64),
        ("phases", np.int64),
        ("count", np.int64),
        ("rows", np.float64, (BLOCK_ROWS, _FIRST_CURRENT + MOST_PHASES)),
    ],
    align=True,
)
"""A recorder: the controller that it passes steps on to, the function that empties it, and `count` rows.

The function is called like a step, with the recorder's address first; it sets `count` to 0.
"""


def row_length(phases: int) -> int:
    """Return the length of a row.

    Parameters
    ----------
    phases : int
        Number of phases.

    Returns
    -------
    int
        Number of columns.
    """
    return _FIRST_CURRENT + phases


@cache
def recording_step() -> Any:
    """Return the recorder's own step, compiled.

    Returns
    -------
    CFunc
        Its `address` is that of a function like `drivegate_step`, whose state is a RECORDER; keep the object.
    """
    # numba has to be imported after the cache folder is known.
    import numba
    from numba.np.numpy_support import carray

    pointer: Any = numba.types.CPointer
    records = (pointer(numba.from_dtype(layout)) for layout in (RECORDER, SENSE, COMMAND))

    def record_step(recorder: Any, sense: Any, command: Any) -> None:
        whole = carray(recorder, 1)
        senses = carray(sense, 1)
        answers = carray(command, 1)
        kept, sensed, answer = whole[0], senses[0], answers[0]
        call_step(kept.step_address, kept.state_address, senses.ctypes.data, answers.ctypes.data)
        if answer.struct_size < 0:
            return
        row = kept.rows[kept.count]
        row[0] = sensed.time
        row[1] = sensed.speed_reference
        row[2] = sensed.speed
        row[3] = sensed.current_magnitude_sum
        row[4] = sensed.half_supply_voltage
        row[_FIRST_OUTPUT] = answer.current_reference
        row[_FIRST_OUTPUT + 1] = answer.advance_angle
        row[_FIRST_OUTPUT + 2] = answer.input_power
        for phase in range(kept.phases):
            row[_FIRST_CURRENT + phase] = double_at(sensed.phase_currents, phase)
        kept.count += 1
        if kept.count == BLOCK_ROWS:
            call_step(kept.empty_address, whole.ctypes.data, senses.ctypes.data, answers.ctypes.data)

    return numba.cfunc(numba.types.void(*records), cache=KEEPS_CACHE)(record_step)


@inlined
def differs(one: float, other: float, one_bits: int, other_bits: int, tolerance: float) -> bool:
    """Return whether two numbers differ: by any bit, or by more than a tolerance.

    Parameters
    ----------
    one, other : float
        The numbers; two NaN do not differ.
    one_bits, other_bits : int
        Their bits.
    tolerance : float
        Greatest difference, relative to the larger number, absolute where that is below 1; negative for none, so
        that every bit counts, that of the sign of zero too.

    Returns
    -------
    bool
        Whether they do.
    """
    if one != one or other != other:
        return one == one or other == other
    if tolerance < 0.0:
        return one_bits != other_bits
    return abs(one - other) > tolerance * max(1.0, abs(one), abs(other))


@unallocating
def _shadow(
    exchange: Exchange,
    begun: int,
    rows: NDArray[np.float64],
    row_bits: NDArray[np.int64],
    judged: NDArray[np.bool_],
    tolerance: float,
    answers: NDArray[np.float64],
) -> tuple[int, int]:
    """Take an answer to each row; return the status and the number of rows that were answered alike."""
    sense = exchange.sense
    command = exchange.command
    for k in range(rows.shape[0]):
        row = rows[k]
        sense[0].time = row[0]
        sense[0].speed_reference = row[1]
        sense[0].speed = row[2]
        sense[0].current_magnitude_sum = row[3]
        sense[0].half_supply_voltage = row[4]
        for phase in range(rows.shape[1] - _FIRST_CURRENT):
            exchange.sensed_currents[phase] = row[_FIRST_CURRENT + phase]
        status = step_controller(exchange, begun + k)
        if status == STOPPED:
            return STOPPED, k
        answers[k, 0] = command[0].current_reference
        answers[k, 1] = command[0].advance_angle
        answers[k, 2] = command[0].input_power
        if status != COMPLETED:
            return status, k
        for output in range(answers.shape[1]):
            if judged[output] and differs(
                row[_FIRST_OUTPUT + output],
                answers[k, output],
                row_bits[k, _FIRST_OUTPUT + output],
                exchange.command_bits[1 + output],
                tolerance,
            ):
                return DIFFERS, k
    return COMPLETED, rows.shape[0]


class Shadow:
    """A controller, already reset, that senses what another one sensed, row by row.

    Parameters
    ----------
    step_address, state_address : int
        Addresses of the controller's step function and of its state.
    phases : int
        Number of phases.
    sense : ndarray of SENSE, shape (1,), optional
        The record to hand to the controller, where another process is to see it.
    sensed_currents : ndarray, shape (m,) or longer, optional
        Where its phase currents belong (A).
    progress : ndarray of int64, shape (1,), optional
        Receives the number of steps begun.

    Attributes
    ----------
    sense : ndarray of SENSE, shape (1,)
        What the controller sensed last.
    currents : ndarray
        Its phase currents (A).
    command : ndarray of COMMAND, shape (1,)
        What it answered last.
    """

    def __init__(
        self,
        *,
        step_address: int,
        state_address: int,
        phases: int,
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
        self.sense: NDArray[Any] = self._exchange.sense
        self.currents: NDArray[np.float64] = self._exchange.sensed_currents
        self.command: NDArray[Any] = self._exchange.command
        self._begun = 0

    def answer(
        self, rows: NDArray[np.float64], *, judged: tuple[str, ...] = (), tolerance: float = -1.0
    ) -> tuple[int, int, NDArray[np.float64]]:
        """Take answers to rows, which have to follow on those before.

        Parameters
        ----------
        rows : ndarray, shape (n, row_length(phases))
            What a recorder wrote.
        judged : tuple of str
            The outputs that must not differ from the recorded ones, of `OUTPUTS`.
        tolerance : float
            As `differs` has it.

        Returns
        -------
        status : int
            `COMPLETED`, `STOPPED`, `NOT_FINITE` or `DIFFERS`.
        done : int
            Number of rows that were answered alike; the next one is what the status is about.
        answers : ndarray, shape (n, 3)
            The answers, `OUTPUTS` in each row, up to that row.
        """
        answers = np.full((len(rows), len(OUTPUTS)), nan)
        rows = np.ascontiguousarray(rows, np.float64)
        status, done = _shadow(
            self._exchange,
            self._begun,
            rows,
            rows.view(np.int64),
            np.array([output in judged for output in OUTPUTS]),
            tolerance,
            answers,
        )
        self._begun += len(rows)
        return int(status), int(done), answers
