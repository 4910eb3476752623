"""Steps on record: exact rows, and another controller that senses the same."""

import ctypes
import math

import numpy as np
import pytest

from drivegate_models.contract.current.records import COMMAND, SENSE
from drivegate_models.loop.exchange import COMPLETED, OUTPUTS, make_exchange
from drivegate_models.loop.given_steps import make_steps
from drivegate_models.loop.step_recording import (
    BLOCK_ROWS,
    RECORDER,
    differs,
    first_difference,
    recording_step,
    row_length,
    senses_in,
)

STEP = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)
PHASES = 3


class Answering:
    """A controller that answers with the speed, the time as angle, and the last phase current as power."""

    def __init__(self, alter=None):
        self.steps = 0
        self.alter = alter or (lambda number, command: None)
        self.callback = STEP(self.step)
        self.address = ctypes.cast(self.callback, ctypes.c_void_p).value

    def step(self, state, sense, command):
        sensed = np.frombuffer((ctypes.c_char * SENSE.itemsize).from_address(sense), SENSE)[0]
        answer = np.frombuffer((ctypes.c_char * COMMAND.itemsize).from_address(command), COMMAND)[0]
        currents = (ctypes.c_double * PHASES).from_address(int(sensed["phase_currents"]))
        answer["current_reference"], answer["advance_angle"] = sensed["speed"], sensed["time"]
        answer["input_power"] = currents[PHASES - 1]
        self.alter(self.steps, answer)
        self.steps += 1


def rows_of(count):
    """Rows in which all is different, with the answers that `Answering` gives."""
    rows = np.random.default_rng(1).normal(size=(count, row_length(PHASES)))
    rows[:, 5], rows[:, 6], rows[:, 7] = rows[:, 2], rows[:, 0], rows[:, -1]
    return rows


def test_a_recorder_passes_steps_on_and_keeps_them_exactly():
    controller, kept = Answering(), []
    recorder = np.zeros(1, RECORDER)

    def empty(address, sense, command):
        assert address == recorder.ctypes.data
        kept.append(recorder[0]["rows"][: recorder[0]["count"], : row_length(PHASES)].copy())
        recorder[0]["count"] = 0

    emptied = STEP(empty)
    recorder[0]["step_address"], recorder[0]["phases"] = controller.address, PHASES
    recorder[0]["empty_address"] = ctypes.cast(emptied, ctypes.c_void_p).value
    rows = rows_of(BLOCK_ROWS + 5)
    answers = np.zeros(len(rows), COMMAND)
    exchange = make_exchange(
        PHASES, step_address=recording_step().address, state_address=recorder.ctypes.data, kept=answers
    )
    assert make_steps(exchange, senses_in(rows)) == (COMPLETED, len(rows))
    given = np.column_stack([answers[name] for name in OUTPUTS])
    assert np.array_equal(given, rows[:, 5:8]), "the recorder must not change an answer"
    assert len(kept) == 1, "a full block is handed over once"
    left = recorder[0]["rows"][: recorder[0]["count"], : row_length(PHASES)]
    assert np.array_equal(np.concatenate([*kept, left]), rows)


def test_the_first_answer_that_differs_in_one_bit_is_found():
    rows = rows_of(20)
    answers = rows[:, 5:8].copy()
    assert first_difference(rows, answers) is None
    answers[7, 1] = np.nextafter(answers[7, 1], np.inf)
    answers[11, 0] = 0.0
    assert first_difference(rows, answers) == 7
    assert first_difference(rows, answers[:7]) is None, "fewer answers than rows are no difference"
    others = tuple(output for output in OUTPUTS if output != "advance_angle")
    assert first_difference(rows, answers, judged=others) == 11
    assert first_difference(rows, answers, tolerance=1e-12) == 11


@pytest.mark.parametrize(
    ("one", "other", "tolerance", "expected"),
    [
        (1.0, 1.0, -1.0, False),
        (1.0, math.nextafter(1.0, 2.0), -1.0, True),
        (0.0, -0.0, -1.0, True),
        (0.0, -0.0, 0.0, False),
        (math.nan, -math.nan, -1.0, False),
        (math.nan, 1.0, 1.0, True),
        (0.0, 1e-9, 1e-9, False),
        (0.0, 2e-9, 1e-9, True),
        (1000.0, 1000.0 + 0.9e-6, 1e-9, False),
        (1000.0, 1000.0 + 1.1e-6, 1e-9, True),
    ],
)
def test_bits_count_unless_there_is_a_tolerance(one, other, tolerance, expected):
    bits = [int(np.float64(number).view(np.int64)) for number in (one, other)]
    assert bool(differs(one, other, *bits, tolerance)) is expected
