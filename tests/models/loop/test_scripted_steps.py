"""Steps of a controller on given signals: what it senses, and how they end."""

import ctypes

import numpy as np
import pytest

from drivegate_models.contract.outer_loop.records import COMMAND, SENSE, STOP
from drivegate_models.loop.exchange import COMPLETED, NOT_FINITE, STOPPED
from drivegate_models.loop.scripted_steps import SIGNALS, ScriptedSteps

STEP = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)


class Recorder:
    """A controller that keeps what it senses, and answers with the number of its step."""

    def __init__(self, special=None):
        self.sensed = []
        self.special = special or {}
        self.callback = STEP(self.step)
        self.address = ctypes.cast(self.callback, ctypes.c_void_p).value

    def step(self, state, sense_address, command_address):
        sense = np.frombuffer((ctypes.c_char * SENSE.itemsize).from_address(sense_address), SENSE)[0]
        command = np.frombuffer((ctypes.c_char * COMMAND.itemsize).from_address(command_address), COMMAND)[0]
        phases = int(sense["phase_count"])
        currents = (ctypes.c_double * phases).from_address(int(sense["phase_currents"]))
        number = len(self.sensed)
        self.sensed.append((*(float(sense[name]) for name in ("time", *SIGNALS)), list(currents)))
        command["current_reference"] = 1.0
        command["advance_angle"] = 0.01 * number
        for name, value in self.special.get(number, {}).items():
            command[name] = value


@pytest.fixture
def signals():
    return np.array([[150.0 + k, 140.0 + k, 10.0 * k, 48.0 - k] for k in range(6)])


def steps_of(recorder, signals, **keywords):
    return ScriptedSteps(
        signals, step_address=recorder.address, state_address=0, phases=5, control_period=0.25, **keywords
    )


def test_every_step_senses_its_row(signals):
    recorder = Recorder()
    steps = steps_of(recorder, signals)
    assert steps.advance() == (COMPLETED, 6)
    assert steps.angles.tolist() == [0.01 * k for k in range(6)]
    for k, (time, *sensed, currents) in enumerate(recorder.sensed):
        assert time == 0.25 * k
        assert sensed == signals[k].tolist()
        assert currents == [10.0 * k / 5 * sign for sign in (1, -1, 1, -1, 1)]


def test_steps_can_be_made_in_parts(signals):
    recorder = Recorder()
    progress = np.zeros(1, np.int64)
    steps = steps_of(recorder, signals, progress=progress)
    assert steps.advance(0, 2) == (COMPLETED, 2)
    assert np.isnan(steps.angles[2:]).all()
    assert progress[0] == 2
    assert steps.advance(2) == (COMPLETED, 6)
    assert [sensed[0] for sensed in recorder.sensed] == [0.25 * k for k in range(6)]


@pytest.mark.parametrize(
    ("special", "status"),
    [
        ({"struct_size": STOP}, STOPPED),
        ({"advance_angle": np.nan}, NOT_FINITE),
        ({"current_reference": np.inf}, NOT_FINITE),
        ({"input_power": -np.inf}, NOT_FINITE),
    ],
)
def test_a_step_without_a_command_ends_them(signals, special, status):
    recorder = Recorder({3: special})
    steps = steps_of(recorder, signals)
    assert steps.advance() == (status, 3)
    assert len(recorder.sensed) == 4
    assert steps.sense[0]["speed"] == 143.0


def test_no_estimate_of_power_is_no_fault(signals):
    steps = steps_of(Recorder({2: {"input_power": np.nan}}), signals)
    assert steps.advance() == (COMPLETED, 6)
