"""Steps of a controller on given signals: what it senses, and how they end."""

import ctypes

import numpy as np
import pytest

from drivegate_models.contract.current.records import COMMAND, SENSE, STOP
from drivegate_models.loop.exchange import COMPLETED, NOT_FINITE, STOPPED
from drivegate_models.loop.given_steps import MAKE_STEPS, given_senses, senses_of
from drivegate_models.loop.loop_inputs import SteppedController
from drivegate_models.loop.step_recording import player_of, playing_step

SCALARS = ("time", "speed_reference", "speed", "current_magnitude_sum", "half_supply_voltage")
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
        self.sensed.append((*(float(sense[name]) for name in SCALARS), list(currents)))
        command["current_reference"] = 1.0
        command["advance_angle"] = 0.01 * number
        for name, value in self.special.get(number, {}).items():
            command[name] = value


PHASES = 5
PERIOD = 0.25


@pytest.fixture
def senses():
    signals = np.array([[150.0 + k, 140.0 + k, 10.0 * k, 48.0 - k] for k in range(6)])
    return senses_of(signals, PHASES, PERIOD)


def made(recorder, senses, **keywords):
    given = given_senses(SteppedController(recorder.address, 0, **keywords), *senses)
    return MAKE_STEPS["current"](given), given


def test_every_step_senses_its_row_and_its_command_is_kept(senses):
    recorder, kept = Recorder(), np.zeros(4, COMMAND)
    ended, _ = made(recorder, senses, kept=kept)
    assert ended == (COMPLETED, 6)
    assert kept["advance_angle"].tolist() == [0.01 * k for k in range(4)], "as many as there is room for"
    for k, (time, *sensed, currents) in enumerate(recorder.sensed):
        assert time == PERIOD * k
        assert sensed == [150.0 + k, 140.0 + k, 10.0 * k, 48.0 - k]
        assert currents == [10.0 * k / PHASES * sign for sign in (1, -1, 1, -1, 1)]


def test_steps_can_be_made_in_parts(senses):
    recorder, progress = Recorder(), np.zeros(1, np.int64)
    first, last = ([rows[part] for rows in senses] for part in (slice(2), slice(2, None)))
    (status, answered), _ = made(recorder, first, progress=progress)
    assert (status, answered, progress[0]) == (COMPLETED, 2, 2)
    assert made(recorder, last)[0] == (COMPLETED, 4)
    assert [sensed[0] for sensed in recorder.sensed] == [PERIOD * k for k in range(6)]


@pytest.mark.parametrize(
    ("special", "status"),
    [
        ({"struct_size": STOP}, STOPPED),
        ({"advance_angle": np.nan}, NOT_FINITE),
        ({"current_reference": np.inf}, NOT_FINITE),
        ({"input_power": -np.inf}, NOT_FINITE),
    ],
)
def test_a_step_without_a_command_ends_them(senses, special, status):
    recorder = Recorder({3: special})
    ended, given = made(recorder, senses)
    assert ended == (status, 3)
    assert len(recorder.sensed) == 4
    assert given.sense[0]["speed"] == 143.0


def test_no_estimate_of_power_is_no_fault(senses):
    assert made(Recorder({2: {"input_power": np.nan}}), senses)[0] == (COMPLETED, 6)


def test_kept_commands_are_given_again_bit_for_bit_and_then_a_stop(senses):
    kept = np.zeros(6, COMMAND)
    made(Recorder({1: {"input_power": np.nan}, 2: {"advance_angle": -0.0}}), senses, kept=kept)
    player, again = player_of(kept), np.zeros(6, COMMAND)
    given = given_senses(SteppedController(playing_step().address, player.ctypes.data, kept=again), *senses)
    assert MAKE_STEPS["current"](given) == (COMPLETED, 6)
    assert again.tobytes() == kept.tobytes(), "a command was changed on the way"
    assert MAKE_STEPS["current"](given) == (STOPPED, 0), "there are no more commands"
