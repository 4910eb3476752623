"""What a controller senses of a link with a capacitor: its voltage, both currents and the flags of its comparators."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.models.pm_ac.recorded_senses import Recorded, recorded
from tests.models.pm_ac.test_duty_signals import drive_of

from drivegate_models.contract.duty.signals import OVERCURRENT, OVERVOLTAGE, TRIP_CURRENT
from drivegate_models.pm_ac.plant.dc_link import RECTIFIER, DcLink

STEPS = 120
SUPPLY = DcLink(1e-3, 0.5, RECTIFIER, 100.0, 0.0, 10.0)


def shown_with(ratios: tuple[float, float, float], speed: float = 0.0, **link: float) -> Recorded:
    """Return a run with constant duty ratios."""

    def answer(_sense: Any, command: Any) -> None:
        for name, ratio in zip(("first_duty", "second_duty", "third_duty"), ratios, strict=True):
            command[name] = ratio

    drive = drive_of(3)._replace(dc_link=SUPPLY._replace(**link))
    return recorded(drive, speed, STEPS, answer)


def test_voltage_and_currents_of_the_link_are_sensed() -> None:
    shown = shown_with((0.9, 0.4, 0.4))
    voltage, source, bridge = (
        shown.senses[name] for name in ("supply_voltage", "source_current", "supply_current")
    )
    assert voltage == pytest.approx(shown.column("link"), abs=0.0)
    assert voltage[-1] < shown.drive.link_voltage, "it sags under load"
    assert source[1:] == pytest.approx(shown.column("source_current")[:-1], abs=0.0)
    period = 1e-4
    charging = SUPPLY.capacitance * np.diff(voltage) / period
    assert source[1:] - bridge[1:] == pytest.approx(charging, abs=1e-6), "the rest charges the capacitor"


def test_a_link_above_its_limit_sets_the_flag_of_overvoltage() -> None:
    # All lower switches brake nothing into the link; a low duty ratio boosts the EMF into it.
    shown = shown_with((0.9, 0.4, 0.4), 0.0, limit=90.0)
    above = shown.column("link_highest")[:-1] > 90.0
    assert above.any()
    assert ((shown.senses["trip"][1:] & OVERVOLTAGE) > 0).tolist() == above.tolist()


def test_a_current_far_above_its_limit_sets_the_flag_of_overcurrent() -> None:
    shown = shown_with((1.0, 0.0, 0.0))
    above = shown.column("peak_current")[:-1] > TRIP_CURRENT * shown.drive.current_limit
    assert above.any()
    assert ((shown.senses["trip"][1:] & OVERCURRENT) > 0).tolist() == above.tolist()
    assert not (shown.senses["trip"] & OVERVOLTAGE).any()
