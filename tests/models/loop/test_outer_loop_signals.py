"""Every field of the contract of current references is what its documentation states, past turns of the shaft."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from math import pi
from typing import Any, Final

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.models.conftest import _motor
from tests.models.schedules import schedule_of

from drivegate_models.contract.current.records import COMMAND, SENSE
from drivegate_models.half_bridge.closed_loop import prepared_loop
from drivegate_models.half_bridge.plant.drive import Drive
from drivegate_models.loop.closed_loop import ClosedLoopRun
from drivegate_models.loop.exchange import COMPLETED
from drivegate_models.loop.loop_inputs import CurrentLoopInputs, SteppedController
from drivegate_models.loop.schedule import Course
from drivegate_models.machine.load import LOCKED, Load

PERIOD: Final = 5e-4
STEPS: Final = 240
"""More than one turn of the shaft."""
CLOCK: Final = 7.0
SPEED: Final = 60.0
REFERENCE: Final = 10.0
RPM: Final = pi / 30.0
STEP: Final = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)


@dataclass(frozen=True)
class Recorded:
    """A run and all that its controller sensed."""

    drive: Drive
    run: ClosedLoopRun
    senses: NDArray[Any]
    """Shape (n,) of SENSE."""
    currents: NDArray[np.float64]
    """Where `phase_currents` of each Sense pointed, shape (n, phases) (A)."""


@cache
def run_of(**answer: float) -> Recorded:
    """Return a run at a speed that is held, with a supply that falls and an answer that stays."""
    drive = _motor()
    senses, currents = np.zeros(STEPS, SENSE), np.zeros((STEPS, drive.phases))
    count = 0
    answer = {"current_reference": REFERENCE, "advance_angle": 0.0} | answer

    def step(_state: int, sense_address: int, command_address: int) -> None:
        nonlocal count
        sense = np.frombuffer((ctypes.c_char * SENSE.itemsize).from_address(sense_address), SENSE)[0]
        command = np.frombuffer((ctypes.c_char * COMMAND.itemsize).from_address(command_address), COMMAND)[0]
        senses[count] = sense
        currents[count] = (ctypes.c_double * drive.phases).from_address(int(sense["phase_currents"]))
        count += 1
        for name, value in answer.items():
            command[name] = value

    kept = STEP(step)
    supply = Course(np.array([0.0, STEPS * PERIOD]), np.array([48.0, 44.0]))
    run = prepared_loop(
        CurrentLoopInputs(
            drive=drive,
            load=Load(LOCKED),
            schedule=schedule_of(SPEED, supply),
            initial_speed=SPEED,
            base_speed=50.0,
            control_period=PERIOD,
            duration=STEPS * PERIOD,
            clock_start=CLOCK,
            trace_every=1,
        ),
        SteppedController(
            int(ctypes.cast(kept, ctypes.c_void_p).value or 0), 0, kept=np.zeros(STEPS, COMMAND)
        ),
    ).run()
    assert run.status == COMPLETED
    return Recorded(drive, run, senses, currents)


def has_its_size(shown: Recorded) -> None:
    assert (shown.senses["struct_size"] == SENSE.itemsize).all()


def grows_by_a_period_from_the_clocks_start(shown: Recorded) -> None:
    assert shown.senses["time"] == pytest.approx(CLOCK + np.arange(STEPS) * PERIOD, abs=1e-12)


def is_the_speed_that_is_asked_for(shown: Recorded) -> None:
    assert (shown.senses["speed_reference"] == SPEED).all()


def is_the_speed_of_the_shaft(shown: Recorded) -> None:
    assert (shown.senses["speed"] == SPEED).all()
    assert shown.run.trace["speed_rpm"] == pytest.approx(shown.senses["speed"] / RPM)


def is_the_number_of_phases(shown: Recorded) -> None:
    assert (shown.senses["phase_count"] == shown.drive.phases).all()


def are_the_currents_at_this_instant(shown: Recorded) -> None:
    assert not shown.currents[0].any()
    later = np.abs(shown.currents[20:])
    # Where the windows are open the regulators keep them within the band; a current dies away where one has closed.
    assert later.max() <= REFERENCE + shown.drive.hysteresis_band + 1e-9
    assert (np.abs(later - REFERENCE) <= shown.drive.hysteresis_band + 1e-9).mean() > 0.5
    assert (shown.currents > 1.0).any()
    assert (shown.currents < -1.0).any()


def is_the_mean_of_the_period_before(shown: Recorded) -> None:
    total = shown.senses["current_magnitude_sum"]
    assert total[0] == 0.0
    assert total[1:] == pytest.approx(shown.run.trace["current_sum_a"][:-1], rel=1e-12)


def is_half_of_the_supply_now(shown: Recorded) -> None:
    expected = np.linspace(48.0, 44.0, STEPS + 1)[:-1]
    assert shown.senses["half_supply_voltage"] == pytest.approx(expected, rel=1e-12)


SENSED: Final[dict[str, Callable[[Recorded], None]]] = {
    "struct_size": has_its_size,
    "time": grows_by_a_period_from_the_clocks_start,
    "speed_reference": is_the_speed_that_is_asked_for,
    "speed": is_the_speed_of_the_shaft,
    "phase_count": is_the_number_of_phases,
    "phase_currents": are_the_currents_at_this_instant,
    "current_magnitude_sum": is_the_mean_of_the_period_before,
    "half_supply_voltage": is_half_of_the_supply_now,
}
"""What is asserted of each field of a Sense."""


@pytest.mark.parametrize("field", SENSE.names)
def test_a_field_of_the_sense_is_what_it_is_documented_as(field: str) -> None:
    assert field in SENSED, f"nothing is asserted of the field '{field}'"
    SENSED[field](run_of())


def stays_its_size() -> None:
    assert run_of().run.last_command["struct_size"][0] == COMMAND.itemsize


def is_the_amplitude_up_to_the_limit() -> None:
    drive = run_of().drive
    for reference, kept in ((5.0, 5.0), (1e3, drive.current_limit)):
        shown = run_of(current_reference=reference)
        assert np.abs(shown.currents).max() <= kept + drive.hysteresis_band + 1e-9
        assert (shown.run.trace["current_reference_a"] == kept).all()
    assert not run_of(current_reference=0.0).currents.any(), "0 blocks the gates"


def opens_the_windows_earlier() -> None:
    """The first phase's current rises above 1 A earlier by the advance, in electrical radians."""
    electrical = run_of().drive.pole_pairs * SPEED
    rises = []
    for advance in (0.0, 0.5):
        first = run_of(advance_angle=advance, current_reference=4.0).currents[:, 0]
        rising = np.flatnonzero((first[1:] > 1.0) & (first[:-1] <= 1.0))
        rises.append(rising[1:] * PERIOD * electrical)
    count = min(map(len, rises))
    earlier = np.angle(np.exp(1j * (rises[0][:count] - rises[1][:count])).mean())
    assert earlier == pytest.approx(0.5, abs=electrical * PERIOD)
    beyond = run_of(advance_angle=3.0)
    assert beyond.run.trace["advance_deg"] == pytest.approx(90.0), "no further than a quarter cycle"


def is_an_estimate() -> None:
    assert np.isnan(run_of().run.last_command["input_power"][0])
    stated = run_of(input_power=123.0)
    assert stated.run.last_command["input_power"][0] == 123.0
    assert stated.run.trace.tobytes() == run_of().run.trace.tobytes()


ANSWERED: Final[dict[str, Callable[[], None]]] = {
    "struct_size": stays_its_size,
    "current_reference": is_the_amplitude_up_to_the_limit,
    "advance_angle": opens_the_windows_earlier,
    "input_power": is_an_estimate,
}
"""What is asserted of each field of a command."""


@pytest.mark.parametrize("field", COMMAND.names)
def test_a_field_of_the_command_does_what_it_is_documented_to(field: str) -> None:
    assert field in ANSWERED, f"nothing is asserted of the field '{field}'"
    ANSWERED[field]()
