"""Where a controller takes the shaft to be: as sensed, and led on where a Hall edge does not come."""

from __future__ import annotations

from math import inf, pi, remainder, tau
from typing import Any

import numpy as np
import pytest

from drivegate_models.contract.duty.records import DUTY_NAMEPLATE, duty_sense_record
from drivegate_models.controllers.duty.position import locate_shaft, reset_position
from drivegate_models.controllers.duty.state import foc_state
from drivegate_models.loop.sensing.hall import (
    hall_angle,
    hall_bits,
    hall_speed,
    lose_switching,
    turn_hall,
    turning_hall,
)

pytestmark = pytest.mark.kernel

PERIOD = 1e-4
POLE_PAIRS = 2
BASE_SPEED = 230.0


class Shaft:
    """A shaft with Hall switches in their places, and what a controller makes of them, period by period."""

    def __init__(self, speed: float) -> None:
        self.state: Any = foc_state("foc").view(np.recarray)[0]
        self.state.pole_pairs, self.state.control_period = POLE_PAIRS, PERIOD
        nameplate: Any = np.zeros(1, DUTY_NAMEPLATE).view(np.recarray)[0]
        nameplate.base_speed, nameplate.control_period = BASE_SPEED, PERIOD
        reset_position(self.state, nameplate, inf)
        self.currents = np.zeros(3)
        self.sensed = duty_sense_record(self.currents)
        self.sense: Any = self.sensed.view(np.recarray)[0]
        self.switches = turning_hall(
            pole_pairs=POLE_PAIRS,
            placement_errors=np.zeros(6),
            greatest_error=0.03,
            hysteresis=0.0,
            clock=1e-7,
            initial_angle=0.0,
            initial_speed=speed,
        )
        self.angle, self.number = 0.0, 0

    def errors(self, speeds: list[float]) -> list[float]:
        """Turn on; return how far the angle that is gone by is ahead at each period's end (rad electrical)."""
        found = []
        for speed in speeds:
            turn_hall(self.switches, self.number * PERIOD, PERIOD, speed)
            self.number += 1
            self.angle += POLE_PAIRS * speed * PERIOD
            self.sense.angle = hall_angle(self.switches, self.number * PERIOD) / POLE_PAIRS
            self.sense.speed = hall_speed(self.switches)
            self.sense.hall = hall_bits(self.switches)
            locate_shaft(self.state, self.sense)
            found.append(remainder(POLE_PAIRS * self.state.seen.angle - self.angle, tau))
        return found


def sector(speed: float) -> int:
    """Return the control periods that a sector takes."""
    return round(pi / 3.0 / (POLE_PAIRS * abs(speed) * PERIOD))


@pytest.mark.parametrize("share", [0.2, 0.5, 1.0, 3.0, -0.2, -1.0])
def test_an_edge_that_is_lost_is_not_missed(share: float) -> None:
    speed = share * BASE_SPEED
    shaft = Shaft(speed)
    shaft.errors([speed] * (2 * sector(speed)))
    lose_switching(shaft.switches)
    late, speeds = [], []
    for _ in range(4 * sector(speed)):
        late += shaft.errors([speed])
        speeds.append(float(shaft.state.seen.speed))
    period = POLE_PAIRS * abs(speed) * PERIOD
    assert max(map(abs, late)) < 0.2 * period + 1e-3
    assert speeds == pytest.approx([speed] * len(speeds), rel=1e-3)


@pytest.mark.parametrize(
    ("share", "led"), [(0.5, True), (0.1, False)], ids=["at speed", "where it may have come to rest"]
)
def test_a_shaft_is_led_on_for_a_sector_and_no_further(share: float, led: bool) -> None:
    speed = share * BASE_SPEED
    shaft = Shaft(speed)
    shaft.errors([speed] * (2 * sector(speed)))
    begin, before = shaft.angle, int(shaft.sense.hall)
    ahead = shaft.errors([0.0] * (4 * sector(speed)))
    assert int(shaft.sense.hall) == before
    inside = pi / 3.0 - (begin - pi / 6.0) % (pi / 3.0)
    farthest = max(ahead) - inside
    assert farthest < 1.1 * pi / 3.0 + 1e-5
    assert (farthest > 0.9 * pi / 3.0) is led
    assert shaft.state.seen.angle == shaft.sense.angle, "in the end it is as sensed"
    assert shaft.state.seen.speed == shaft.sense.speed < 0.4 * speed


def test_what_is_sensed_otherwise_is_taken_as_it_is() -> None:
    shaft = Shaft(BASE_SPEED)
    shaft.sense.hall = -1
    shaft.sense.winding_temperature = 20.0
    shaft.sense.mean_voltages = 0.0
    for angle, speed in ((0.1, 100.0), (0.1, 100.0), (0.1, 100.0)):
        shaft.sense.angle, shaft.sense.speed, shaft.sense.reference = angle, speed, 7.0
        assert locate_shaft(shaft.state, shaft.sense) == shaft.sense
