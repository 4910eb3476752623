"""Every field of a command of duty ratios does what its documentation states."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, Final

import numpy as np
import pytest
from tests.models.pm_ac.recorded_senses import Recorded, recorded
from tests.models.pm_ac.test_duty_signals import drive_of

from drivegate_models.contract.duty.records import DUTY_COMMAND
from drivegate_models.contract.duty.signals import (
    LEG_HIGH,
    LEG_LOW,
    LEG_OFF,
    LEG_PWM,
)
from drivegate_models.loop.schedule import Course
from drivegate_models.pm_ac.loop_records import TRACE
from drivegate_models.pm_ac.plant.dc_link import BATTERY, DcLink

STEPS: Final = 200
RATIOS: Final = ("first_duty", "second_duty", "third_duty")
LEGS: Final = ("first_leg", "second_leg", "third_leg")
ESTIMATES: Final = ("torque", "angle", "speed", "input_power")


@cache
def at_rest(**fields: float) -> Recorded:
    """Return a run on a shaft at rest that answers ratios of 1/2 but for some fields."""

    def answer(_sense: Any, command: Any) -> None:
        for name, value in (dict.fromkeys(RATIOS, 0.5) | fields).items():
            command[name] = value

    return recorded(drive_of(3), 0.0, STEPS, answer)


def raises_its_current(field: str) -> None:
    phase = RATIOS.index(field)
    shown = at_rest(**{field: 0.7})
    # The third of the link that this phase is above the middle of all, over the resistance.
    drive = shown.drive
    expected = np.full(3, -0.5)
    expected[phase] = 1.0
    expected *= 2.0 / 3.0 * 0.2 * drive.link_voltage / drive.resistance
    assert shown.currents[-1] == pytest.approx(expected, rel=0.02)
    assert not shown.currents[: drive.modulator.update_delay + 1].any(), "it acts after the update delay"
    assert shown.currents[drive.modulator.update_delay + 1].any()


def holds_its_leg(field: str) -> None:
    ratio = RATIOS[LEGS.index(field)]
    for state, same in ((LEG_HIGH, 1.0), (LEG_LOW, 0.0)):
        assert at_rest(**{field: state}).run.trace == pytest.approx(
            at_rest(**{ratio: same}).run.trace, nan_ok=True
        )
    assert at_rest(**{field: LEG_PWM}).run.trace.tobytes() == at_rest().run.trace.tobytes()
    off = at_rest(**{field: LEG_OFF, "first_duty": 0.7, "second_duty": 0.3, "third_duty": 0.5})
    assert np.abs(off.currents[-1, LEGS.index(field)]) < 1e-6
    assert np.abs(off.currents[-1]).max() > 1.0


def changes_nothing(field: str) -> None:
    for value in (0.0, 2.0, -1.0):
        shown = at_rest(**{field: value})
        assert shown.run.trace.tobytes() == at_rest().run.trace.tobytes()
        assert (shown.run.commands[field] == value).all(), "it is recorded"


def is_an_estimate(field: str) -> None:
    assert np.isnan(at_rest().run.commands[field]).all(), "it is NaN where it is left out"
    changes_nothing(field)


def is_its_code(field: str) -> None:
    assert not at_rest().run.commands[field].any(), "it is 0 where it is left out"
    changes_nothing(field)


def turns_the_chopper_on(field: str) -> None:
    assert np.isnan(at_rest().run.commands[field]).all(), "it is NaN where it is left out"
    link = DcLink(1e-3, 0.5, BATTERY, 1e3, 0.0, 0.0, 900.0, 800.0, 0.1)

    def answer(_sense: Any, command: Any) -> None:
        for name, value in (dict.fromkeys(RATIOS, 0.5) | {field: 0.25}).items():
            command[name] = value

    drive = drive_of(3)._replace(dc_link=link)
    shown = recorded(drive, 0.0, STEPS, answer)
    power = shown.run.trace[:, TRACE.index("chopper_power")]
    voltage = shown.run.trace[:, TRACE.index("link_mean")]
    assert not power[: drive.modulator.update_delay].any(), "it acts with the duty ratios"
    late = slice(drive.modulator.update_delay + 1, None)
    assert power[late] == pytest.approx(0.25 * 0.1 * voltage[late] ** 2, rel=1e-2)


def stays_its_size(field: str) -> None:
    assert (at_rest().run.commands[field] == DUTY_COMMAND.itemsize).all()


ANSWERED: Final[dict[str, Callable[[str], None]]] = {
    "struct_size": stays_its_size,
    **dict.fromkeys(RATIOS, raises_its_current),
    **dict.fromkeys(LEGS, holds_its_leg),
    "next_period": changes_nothing,
    **dict.fromkeys(ESTIMATES, is_an_estimate),
    "fault": is_its_code,
    "brake_duty": turns_the_chopper_on,
}
"""What is asserted of each field of a command."""


@pytest.mark.parametrize("field", DUTY_COMMAND.names)
def test_a_field_of_the_command_does_what_it_is_documented_to(field: str) -> None:
    assert field in ANSWERED, f"nothing is asserted of the field '{field}'"
    ANSWERED[field](field)


def test_a_torque_reference_is_shown_from_its_period_on() -> None:
    torque = Course(np.array([0.0, 0.005, 0.005]), np.array([0.0, -1.0, 2.0]))

    def answer(_sense: Any, command: Any) -> None:
        for name in RATIOS:
            command[name] = 0.5

    shown = recorded(drive_of(3), -100.0, 60, answer, torque_reference=torque)
    assert shown.senses["reference"] == pytest.approx([*np.linspace(0.0, -1.0, 51)[:-1], *[2.0] * 10])
