"""The observer of a shaft between Hall edges: at low speed it follows a load that the timer averages away."""

from __future__ import annotations

from math import copysign, inf, pi, remainder, tau
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegate_models.contract.duty.records import DUTY_NAMEPLATE, duty_sense_record
from drivegate_models.controllers.duty.hall_observer import reset_observer
from drivegate_models.controllers.duty.position import locate_shaft, regulated_speed, reset_position
from drivegate_models.controllers.duty.state import foc_state
from drivegate_models.loop.sensing.hall import hall_angle, hall_bits, hall_speed, turn_hall, turning_hall

pytestmark = pytest.mark.kernel

PERIOD = 1e-4
POLE_PAIRS = 2
BASE_SPEED = 230.0
INERTIA = 2e-3
SECTOR = pi / 3.0


class Shaft:
    """A shaft under a known torque and an unknown load, its Hall switches, and where a speed regulator sees it."""

    def __init__(self, speed: float, *, angle: float = 0.0, led_on_from: float = BASE_SPEED) -> None:
        self.state: Any = foc_state("foc").view(np.recarray)[0]
        self.state.pole_pairs, self.state.control_period, self.state.regulates_speed = POLE_PAIRS, PERIOD, 1
        nameplate: Any = np.zeros(1, DUTY_NAMEPLATE).view(np.recarray)[0]
        nameplate.base_speed, nameplate.control_period = BASE_SPEED, PERIOD
        reset_position(self.state, nameplate, inf)
        reset_observer(self.state, 40.0, INERTIA)
        self.state.led_on_from = led_on_from
        self.currents = np.zeros(3)
        self.sensed = duty_sense_record(self.currents)
        self.sense: Any = self.sensed.view(np.recarray)[0]
        self.switches = turning_hall(
            pole_pairs=POLE_PAIRS,
            placement_errors=np.zeros(6),
            greatest_error=0.0,
            hysteresis=0.0,
            clock=1e-7,
            initial_angle=angle,
            initial_speed=speed,
        )
        self.angle, self.speed, self.number = angle, speed, 0
        self._see()

    def turn(self, steps: int, torque: float = 0.0, load: float = 0.0) -> None:
        """Turn on; a load opposes the rotation, and a torque can reverse it."""
        for _ in range(steps):
            self.state.seen_torque = torque
            turn_hall(self.switches, self.number * PERIOD, PERIOD, self.speed)
            self.angle += POLE_PAIRS * self.speed * PERIOD
            pushed = self.speed + torque / INERTIA * PERIOD
            self.speed = copysign(max(abs(pushed) - load / INERTIA * PERIOD, 0.0), pushed)
            self.number += 1
            self._see()

    def _see(self) -> None:
        self.sense.angle = hall_angle(self.switches, self.number * PERIOD) / POLE_PAIRS
        self.sense.speed = hall_speed(self.switches)
        self.sense.hall = hall_bits(self.switches)
        locate_shaft(self.state, self.sense)

    @property
    def error(self) -> float:
        """How far the angle that is gone by is ahead (rad electrical)."""
        return remainder(POLE_PAIRS * float(self.state.seen.angle) - self.angle, tau)


def test_a_load_at_low_speed_is_followed_where_the_timer_lags_by_a_cycle() -> None:
    shaft = Shaft(40.0)
    # Whole sectors at 13 ms: three of them after a load that takes a quarter of the speed in that time.
    shaft.turn(300)
    shaft.turn(500, torque=0.3, load=0.7)
    assert shaft.speed == pytest.approx(30.0, abs=0.5)
    assert float(shaft.state.seen.speed) == pytest.approx(shaft.speed, rel=0.02)
    assert abs(shaft.error) < 0.05
    assert float(shaft.sense.speed) > 1.08 * shaft.speed


@pytest.mark.parametrize("angle", [0.1, 0.6, 1.5])
def test_a_start_is_followed_from_its_first_edges_on(angle: float) -> None:
    shaft = Shaft(0.0, angle=angle)
    shaft.turn(1000, torque=1.5, load=0.7)
    assert float(shaft.state.seen.speed) == pytest.approx(shaft.speed, rel=0.05)
    assert abs(shaft.error) < 0.1


def test_a_shaft_that_stops_is_taken_for_slow_and_for_in_the_middle_of_its_sector() -> None:
    shaft = Shaft(20.0)
    shaft.turn(300)
    shaft.turn(400, load=2.0)
    shaft.turn(600, torque=1.9, load=2.0)
    assert shaft.speed == 0.0
    since = float(shaft.state.since_edge)
    assert 0.0 < float(shaft.state.seen.speed) <= SECTOR / POLE_PAIRS / since + 1e-9
    assert abs(shaft.error) <= 0.5 * SECTOR + 1e-9


def test_a_speed_regulator_notices_a_late_edge_while_the_angle_is_led_on() -> None:
    shaft = Shaft(100.0, led_on_from=30.0)
    shaft.turn(300)
    shaft.speed = 0.0
    edge = float(shaft.state.since_edge)
    shaft.turn(round((1.5 * SECTOR / POLE_PAIRS / 100.0 - edge) / PERIOD))
    assert float(shaft.state.seen.speed) == pytest.approx(100.0, rel=0.01)
    assert regulated_speed(shaft.state, shaft.state.seen, shaft.sense.speed) == pytest.approx(
        100.0 / 1.5, rel=0.03
    )


def test_an_edge_is_overdue_once_when_the_leading_on_ends() -> None:
    shaft = Shaft(100.0, led_on_from=30.0)
    shaft.turn(300)
    shaft.speed = 0.0
    overdue = []
    for _ in range(300):
        shaft.turn(1)
        if shaft.state.is_overdue == 1:
            overdue.append(float(shaft.state.since_edge) * 100.0 * POLE_PAIRS / SECTOR)
    assert len(overdue) == 1
    assert overdue[0] == pytest.approx(2.1, abs=0.03), "a sector, and one that is led on"


@pytest.mark.parametrize(("speed", "angle"), [(80.0, 0.4), (60.0, 0.8), (100.0, 0.2)])
@pytest.mark.parametrize("load", [1.0, 1.3, 1.5])
def test_a_shaft_that_turns_round_may_be_late_at_the_edge_that_it_came_from(
    speed: float, angle: float, load: float
) -> None:
    shaft = Shaft(speed, angle=angle, led_on_from=30.0)
    shaft.turn(300)
    # The load helps to brake and hinders on the way back, which lasts longer than the way there.
    while shaft.speed > -20.0:
        shaft.turn(1, torque=-1.9, load=load)
        assert shaft.state.is_overdue == 0, f"at {shaft.speed:.3g} rad/s"


@given(
    st.floats(0.0, 60.0),
    st.floats(0.0, tau),
    st.lists(
        st.tuples(st.integers(1, 200), st.floats(-2.5, 2.5), st.floats(0.0, 2.5)), min_size=1, max_size=5
    ),
)
@settings(max_examples=60)
def test_whatever_the_shaft_does_its_angle_is_in_the_sector_that_the_switches_show(
    speed: float, angle: float, course: list[tuple[int, float, float]]
) -> None:
    shaft = Shaft(speed, angle=angle)
    for steps, torque, load in course:
        for _ in range(steps):
            shaft.turn(1, torque, load)
            assert abs(shaft.error) <= SECTOR + 1e-5
            most = SECTOR / (POLE_PAIRS * max(float(shaft.state.since_edge), PERIOD))
            assert abs(regulated_speed(shaft.state, shaft.state.seen, 0.0)) <= most * (1.0 + 1e-9)
