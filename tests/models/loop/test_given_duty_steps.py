"""Steps of a controller of duty ratios on given Senses, and commands that are given again."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from drivegate_models.contract.duty.records import DUTY_COMMAND, DUTY_SENSE
from drivegate_models.loop.duty_command import BAD_LEG
from drivegate_models.loop.exchange import COMPLETED, NOT_FINITE, STOPPED
from drivegate_models.loop.given_steps import MAKE_STEPS, given_senses
from drivegate_models.loop.loop_inputs import SteppedController
from drivegate_models.loop.step_recording import player_of, playing_step

STEP = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)
CURRENTS = np.arange(15.0).reshape(5, 3)


def senses() -> Any:
    given = np.zeros(5, DUTY_SENSE)
    given["time"] = np.arange(5)
    return given


def made(special: Callable[[int, Any], None], **keywords: Any) -> tuple[tuple[int, int], list[Any]]:
    """Step a controller that answers with its first phase current."""
    sensed = []

    def step(_state: int, sense_address: int, command_address: int) -> None:
        sense = np.frombuffer((ctypes.c_char * DUTY_SENSE.itemsize).from_address(sense_address), DUTY_SENSE)[
            0
        ]
        command = np.frombuffer(
            (ctypes.c_char * DUTY_COMMAND.itemsize).from_address(command_address), DUTY_COMMAND
        )
        currents = list((ctypes.c_double * 3).from_address(int(sense["phase_currents"])))
        assert np.isnan(command[0]["torque"]), "what was answered before is still there"
        sensed.append((float(sense["time"]), currents))
        for name in ("first_duty", "second_duty", "third_duty", "torque"):
            command[name] = currents[0]
        special(len(sensed) - 1, command)

    callback = STEP(step)
    address = ctypes.cast(callback, ctypes.c_void_p).value or 0
    ended = MAKE_STEPS["duty"](given_senses(SteppedController(address, 0, **keywords), senses(), CURRENTS))
    return (int(ended[0]), int(ended[1])), sensed


def nothing(_number: int, _command: Any) -> None:
    """Do nothing particular."""


def test_every_step_senses_its_own_and_is_counted_and_kept() -> None:
    progress, kept = np.zeros(1, np.int64), np.zeros(3, DUTY_COMMAND)
    ended, sensed = made(nothing, progress=progress, kept=kept)
    assert ended == (COMPLETED, 5)
    assert sensed == [(float(k), CURRENTS[k].tolist()) for k in range(5)]
    assert progress[0] == 5
    assert kept["first_duty"].tolist() == [0.0, 3.0, 6.0], "as many as there is room for"


@pytest.mark.parametrize(
    ("field", "value", "status"),
    [
        ("second_duty", np.nan, NOT_FINITE),
        ("third_duty", np.inf, NOT_FINITE),
        ("second_leg", 7, BAD_LEG),
        ("third_leg", -1, BAD_LEG),
        ("struct_size", -1, STOPPED),
    ],
)
def test_an_answer_that_is_none_ends_the_steps(field: str, value: float, status: int) -> None:
    def special(number: int, command: Any) -> None:
        if number == 2:
            command[field] = value

    assert made(special)[0] == (status, 2)


def test_kept_commands_are_given_again_bit_for_bit_and_then_it_stops() -> None:
    commands = np.zeros(4, DUTY_COMMAND)
    commands["struct_size"] = DUTY_COMMAND.itemsize
    commands["first_duty"] = np.linspace(0.0, 1.0, 4)
    commands["second_leg"] = (0, 1, 2, 3)
    commands["torque"] = np.nan
    commands["fault"] = (5, 6, 7, 8)
    player, step = player_of(commands), playing_step()
    kept = np.zeros(5, DUTY_COMMAND)
    given = given_senses(SteppedController(step.address, player.ctypes.data, kept=kept), senses(), CURRENTS)
    status, answered = MAKE_STEPS["duty"](given)
    assert (status, answered) == (STOPPED, 4)
    assert kept[:4].tobytes() == commands.tobytes()
