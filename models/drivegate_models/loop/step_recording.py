"""Recording of every step of a controller, its Sense and its command, and the first difference of two records.

A recorder is placed between the closed loop and a controller. It passes each step on and writes a row of exact
numbers. Its memory is one block of rows; it passes a full block to a function that empties it.
"""

from __future__ import annotations

from functools import cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.calling import call_step, double_at, step_signature
from drivegate_models.compilation.kernels import KEEPS_CACHE, inlined, unallocating
from drivegate_models.contract.current.records import COMMAND, SENSE
from drivegate_models.loop.exchange import OUTPUTS
from drivegate_models.loop.given_steps import SCALARS

MOST_PHASES: Final = 64
"""Maximum number of phase currents in a row."""

BLOCK_ROWS: Final = 1024
"""Number of rows in a recorder's block."""

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
"""A recorder: the controller to which it passes steps, the function that empties it, and `count` rows.

The function is called like a step, with the recorder's address first; it sets `count` to 0.
"""


def row_length(phases: int) -> int:
    """Return the number of columns in a row for a number of phases."""
    return _FIRST_CURRENT + phases


@cache
def recording_step() -> Any:
    """Return the recorder's own step, compiled.

    Returns
    -------
    CFunc
        Its `address` is that of a function like `drivegate_step`, whose state is a RECORDER. The caller must retain it.
    """
    # numba must be imported after the cache folder is known.
    import numba
    from numba.np.numpy_support import carray

    signature = step_signature(RECORDER, SENSE, COMMAND)

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

    return numba.cfunc(signature, cache=KEEPS_CACHE)(record_step)


@inlined
def differs(one: float, other: float, one_bits: int, other_bits: int, tolerance: float) -> bool:
    """Return True if two numbers differ by any bit, or by more than a tolerance; two NaN do not differ.

    Parameters
    ----------
    one, other : float
        The numbers, in the same unit.
    one_bits, other_bits : int
        Their bits, read as 64-bit integers.
    tolerance : float
        Maximum difference, relative to the larger number, and absolute if that is below 1. Negative to compare every
        bit, including the sign of zero.

    Returns
    -------
    bool
        False if the difference is within the tolerance.
    """
    if one != one or other != other:
        return one == one or other == other
    if tolerance < 0.0:
        return one_bits != other_bits
    return abs(one - other) > tolerance * max(1.0, abs(one), abs(other))


@unallocating
def _first_difference(
    outputs: NDArray[np.float64],
    output_bits: NDArray[np.int64],
    answers: NDArray[np.float64],
    answer_bits: NDArray[np.int64],
    judged: NDArray[np.bool_],
    tolerance: float,
) -> int:
    for k in range(answers.shape[0]):
        for output in range(answers.shape[1]):
            if judged[output] and differs(
                outputs[k, output],
                answers[k, output],
                output_bits[k, output],
                answer_bits[k, output],
                tolerance,
            ):
                return k
    return int(answers.shape[0])


def first_difference(
    rows: NDArray[np.float64],
    answers: NDArray[np.float64],
    *,
    judged: tuple[str, ...] = OUTPUTS,
    tolerance: float = -1.0,
) -> int | None:
    """Return the number of the first row whose command differs from the recorded one.

    Parameters
    ----------
    rows : ndarray, shape (n, row_length(phases))
        The rows of a recorder.
    answers : ndarray, shape (k, 3)
        Another controller's `OUTPUTS` for the first k rows.
    judged : tuple of str
        The outputs that must not differ, of `OUTPUTS`.
    tolerance : float
        See `differs`.

    Returns
    -------
    int or None
        Number of the row; None if there is no difference.
    """
    recorded = np.ascontiguousarray(rows[:, _FIRST_OUTPUT:_FIRST_CURRENT])
    answers = np.ascontiguousarray(answers)
    kept = np.array([output in judged for output in OUTPUTS])
    found = _first_difference(
        recorded, recorded.view(np.int64), answers, answers.view(np.int64), kept, tolerance
    )
    return None if found == len(answers) else int(found)


def senses_in(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the Senses in recorded rows, without the commands.

    Parameters
    ----------
    rows : ndarray, shape (n, row_length(phases))
        The rows of a recorder.

    Returns
    -------
    ndarray, shape (n, len(SCALARS) + phases)
        Rows for `given_steps.make_given_steps`.
    """
    return np.delete(rows, np.s_[_FIRST_OUTPUT:_FIRST_CURRENT], axis=1)
