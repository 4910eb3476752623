"""Steps on record: exact rows, whatever the contract."""

import ctypes

import numpy as np
import pytest

from drivegate_models.contract.layout import CURRENT, DUTY
from drivegate_models.loop.exchange import COMPLETED
from drivegate_models.loop.given_steps import MAKE_STEPS, given_senses
from drivegate_models.loop.loop_inputs import SteppedController
from drivegate_models.loop.step_recording import recorder_of, recording_step, row_layout

STEP = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)
STEPS, PHASES = 9, 3


class Answering:
    """A controller that answers in all fields with the time, but for the last: the last phase current."""

    def __init__(self, layout):
        self.layout = layout
        self.callback = STEP(self.step)
        self.address = ctypes.cast(self.callback, ctypes.c_void_p).value

    def step(self, state, sense, command):
        sensed = record_at(sense, self.layout.sense)
        answer = record_at(command, self.layout.command)
        currents = (ctypes.c_double * PHASES).from_address(int(sensed["phase_currents"]))
        *others, last = self.layout.outputs
        for name in others:
            answer[name] = sensed["time"]
        answer[last] = currents[PHASES - 1]


def record_at(address, layout):
    return np.frombuffer((ctypes.c_char * layout.itemsize).from_address(address), layout)[0]


@pytest.mark.parametrize("layout", [CURRENT, DUTY], ids=lambda layout: layout.name)
def test_a_recorder_passes_steps_on_and_records_them_exactly(layout):
    senses, currents = np.zeros(STEPS, layout.sense), np.arange(STEPS * PHASES * 1.0).reshape(STEPS, PHASES)
    # A state of a leg is a whole number from 0 to 3.
    senses["time"], senses["speed"] = np.arange(STEPS) % 3, np.linspace(-1.0, 1.0, STEPS)
    controller, rows = Answering(layout), np.zeros(STEPS - 2, row_layout(layout, PHASES))
    recorder = recorder_of(rows, controller.address, 0)
    kept = np.zeros(STEPS, layout.command)
    given = given_senses(
        SteppedController(recording_step().address, recorder.ctypes.data, kept=kept), senses, currents
    )
    assert MAKE_STEPS[layout.name](given) == (COMPLETED, STEPS)
    *others, last = layout.outputs
    assert kept[last].tolist() == currents[:, -1].tolist(), "the recorder must not change an answer"
    assert all(kept[name].tolist() == senses["time"].tolist() for name in others)
    assert recorder[0]["count"] == len(rows), "there is no room for more"
    assert rows["command"].tobytes() == kept[: len(rows)].tobytes()
    assert np.array_equal(rows["currents"], currents[: len(rows)])
    assert all(np.array_equal(rows["sense"][name], senses[name][: len(rows)]) for name in ("time", "speed"))
