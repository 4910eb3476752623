"""Steps on record: exact rows, and another controller that senses the same."""

import ctypes
import math

import numpy as np
import pytest

from drivegate_models.contract.outer_loop.records import COMMAND, SENSE
from drivegate_models.loop.exchange import COMPLETED, NOT_FINITE, STOPPED
from drivegate_models.loop.step_recording import (
    BLOCK_ROWS,
    DIFFERS,
    OUTPUTS,
    RECORDER,
    Shadow,
    differs,
    recording_step,
    row_length,
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


def shadow_of(controller):
    return Shadow(step_address=controller.address, state_address=0, phases=PHASES)


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
    shadow = Shadow(step_address=recording_step().address, state_address=recorder.ctypes.data, phases=PHASES)
    rows = rows_of(BLOCK_ROWS + 5)
    status, done, answers = shadow.answer(rows, judged=OUTPUTS)
    assert (status, done) == (COMPLETED, len(rows)), "the recorder must not change an answer"
    assert np.array_equal(answers, rows[:, 5:8])
    assert len(kept) == 1, "a full block is handed over once"
    left = recorder[0]["rows"][: recorder[0]["count"], : row_length(PHASES)]
    assert np.array_equal(np.concatenate([*kept, left]), rows)


def test_a_shadow_stops_at_the_first_answer_that_differs_in_one_bit():
    def alter(number, command):
        if number == 7:
            command["advance_angle"] = np.nextafter(command["advance_angle"], np.inf)

    controller, rows = Answering(alter), rows_of(20)
    status, done, answers = shadow_of(controller).answer(rows, judged=OUTPUTS)
    assert (status, done, controller.steps) == (DIFFERS, 7, 8), "no step is made after the first difference"
    assert answers[7, 1] != rows[7, 6]
    others = tuple(output for output in OUTPUTS if output != "advance_angle")
    assert shadow_of(Answering(alter)).answer(rows, judged=others)[:2] == (COMPLETED, 20)
    assert shadow_of(Answering(alter)).answer(rows, judged=OUTPUTS, tolerance=1e-12)[:2] == (COMPLETED, 20)


@pytest.mark.parametrize(
    ("field", "value", "status"),
    [
        ("struct_size", -1, STOPPED),
        ("current_reference", math.nan, NOT_FINITE),
        ("advance_angle", math.inf, NOT_FINITE),
        ("input_power", -math.inf, NOT_FINITE),
    ],
)
def test_what_is_no_answer_ends_the_steps(field, value, status):
    def alter(number, command):
        if number == 3:
            command[field] = value

    assert shadow_of(Answering(alter)).answer(rows_of(10))[:2] == (status, 3)


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
