"""Hall switches: exact where nothing is wrong, six edges a cycle whatever is, and the speed of a slow shaft."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from drivegate_models.loop.sensing.hall import EDGES, SECTOR, Hall, hall_speed, turn_hall, turning_hall

pytestmark = pytest.mark.kernel

PERIOD = 5e-4
CLOCK = 1e-9
POLE_PAIRS = 11
DEGREE = math.pi / 180.0
RPM = math.pi / 30.0

errors_of_edges = st.lists(st.floats(-15.0, 15.0), min_size=EDGES, max_size=EDGES)


def hall(
    *,
    speed: float = 0.0,
    errors_deg: list[float] | None = None,
    hysteresis_deg: float = 0.0,
    angle_deg: float = 0.0,
    pole_pairs: int = POLE_PAIRS,
    clock: float = CLOCK,
) -> Hall:
    errors = np.radians(errors_deg or [0.0] * EDGES)
    return turning_hall(
        pole_pairs=pole_pairs,
        placement_errors=errors,
        greatest_error=float(np.abs(errors).max()),
        hysteresis=hysteresis_deg * DEGREE,
        clock=clock,
        initial_angle=angle_deg * DEGREE,
        initial_speed=speed,
    )


def turn(switches: Hall, speeds: list[float]) -> tuple[list[float], list[float]]:
    """Turn the shaft, one control period a speed; return the measured speeds and the angle's errors."""
    measured, errors = [], []
    for number, speed in enumerate(speeds):
        errors.append(turn_hall(switches, number * PERIOD, PERIOD, speed))
        measured.append(hall_speed(switches))
    return measured, errors


@pytest.mark.parametrize("rpm", [5.0, 500.0, 1500.0, 4000.0])
@pytest.mark.parametrize("pole_pairs", [1, 4, 11])
def test_speed_angle_and_edges_are_exact_without_errors(rpm: float, pole_pairs: int) -> None:
    speed, electrical = rpm * RPM, pole_pairs * rpm * RPM
    switches = hall(speed=speed, pole_pairs=pole_pairs)
    measured, errors = turn(switches, [speed] * 400)
    # A tick at either end of the measured cycle, and one where an edge is late.
    tolerance = 2.0 * electrical * CLOCK / (2.0 * math.pi) + 1e-12
    assert measured == pytest.approx([speed] * 400, rel=max(tolerance, 1e-9) * 6.0)
    # The angle's own tick, and what the speed's makes of a sector; and the hair that it keeps off its ends.
    assert max(map(abs, errors)) <= 3.0 * electrical * CLOCK + 2e-6, "the angle is off without an error"
    times = sorted(CLOCK * switches.ticks)
    assert times[-1] > 400 * PERIOD - SECTOR / electrical - CLOCK, "the last edge is not timed"
    assert [after - before for before, after in pairwise(times)] == pytest.approx(
        [SECTOR / electrical] * 6, abs=1.1 * CLOCK
    )


@given(errors_of_edges, st.floats(0.0, 15.0), st.floats(0.0, 359.9), st.floats(10.0, 300.0))
@settings(max_examples=50)
def test_a_shaft_that_turned_before_the_run_is_measured_as_one_that_goes_on(
    errors: list[float], hysteresis: float, angle: float, speed: float
) -> None:
    for sense in (speed, -speed):
        begun = hall(speed=sense, errors_deg=errors, hysteresis_deg=hysteresis, angle_deg=angle, pole_pairs=1)
        assert hall_speed(begun) == sense
        measured, _ = turn(begun, [sense] * round(7.0 / (speed * PERIOD)))
        assert measured == pytest.approx([sense] * len(measured), rel=1e-4)


@given(errors_of_edges, st.floats(0.0, 15.0), st.floats(0.0, 359.9), st.integers(1, 20))
@settings(max_examples=100)
def test_there_are_six_edges_a_cycle_and_like_ones_give_the_speed(
    errors: list[float], hysteresis: float, angle: float, pole_pairs: int
) -> None:
    speed = 100.0
    switches = hall(
        speed=speed, errors_deg=errors, hysteresis_deg=hysteresis, angle_deg=angle, pole_pairs=pole_pairs
    )
    begun = int(switches.numbers[0])
    cycles = 3
    # A length that takes whole cycles to a little before an edge, or behind it, never to both.
    periods = math.floor(cycles * 2.0 * math.pi / (pole_pairs * speed * PERIOD))
    measured, _ = turn(switches, [speed] * periods)
    rest = cycles * 2.0 * math.pi / (pole_pairs * speed) - periods * PERIOD
    turn_hall(switches, periods * PERIOD, rest, speed)
    edges = int(switches.numbers[0]) - begun
    near_edge = min(float(switches.memory[0]), SECTOR) < 1e-9
    assert edges == cycles * EDGES or (near_edge and abs(edges - cycles * EDGES) == 1)
    assert measured == pytest.approx([speed] * periods, rel=1e-4), "placement errors show in the speed"


@pytest.mark.parametrize("degrees", [0.5, 3.0, 15.0])
def test_hysteresis_alone_makes_the_angle_late_by_itself(degrees: float) -> None:
    speed = 1000.0 * RPM
    _, errors = turn(hall(speed=speed, hysteresis_deg=degrees), [speed] * 500)
    assert errors == pytest.approx([-degrees * DEGREE] * 500, abs=1e-5)


@given(
    errors_of_edges,
    st.floats(0.0, 15.0),
    st.floats(0.0, 200.0),
    st.lists(st.floats(-30.0, 30.0), min_size=1, max_size=150),
)
@example([0.0] * EDGES, 0.0, 5e-324, [0.0])
@settings(max_examples=100)
def test_the_angle_is_off_by_no_more_than_a_sector_and_the_edges_errors(
    errors: list[float], hysteresis: float, speed: float, changes: list[float]
) -> None:
    switches = hall(speed=speed, errors_deg=errors, hysteresis_deg=hysteresis)
    speeds = [max(speed + sum(changes[: count + 1]), 0.0) for count in range(len(changes))]
    _, seen = turn(switches, speeds)
    lags = switches.lags
    assert max(seen) <= SECTOR - lags.min() + 1e-9
    assert min(seen) >= -SECTOR - lags.max() - 1e-9


def test_a_shaft_at_rest_has_no_speed_and_the_middle_of_its_sector() -> None:
    # The edge at 30 degrees has passed, that at 90 degrees has not.
    switches = hall(angle_deg=40.0)
    measured, errors = turn(switches, [0.0] * 50)
    assert measured == [0.0] * 50
    assert errors == pytest.approx([20.0 * DEGREE] * 50), "not the 60 degrees between 30 and 90"


def test_the_speed_begins_with_the_second_edge() -> None:
    switches = hall(angle_deg=40.0)
    speed = 40.0 * RPM
    seen = []
    for number in range(400):
        turn_hall(switches, number * PERIOD, PERIOD, speed)
        edges = (40.0 + 6.0 * 40.0 * POLE_PAIRS * (number + 1) * PERIOD - 30.0) // 60.0
        seen.append((edges, hall_speed(switches)))
    assert {measured for edges, measured in seen if edges < 2} == {0.0}
    after = [measured for edges, measured in seen if edges >= 2]
    assert after == pytest.approx([speed] * len(after), rel=1e-6)


def test_the_speed_of_a_shaft_that_stops_falls_as_its_sector_over_the_time_without_an_edge() -> None:
    speed = 1000.0 * RPM
    switches = hall(speed=speed, errors_deg=[1.0, -1.0, 0.0, 0.5, 0.0, 0.0])
    turn(switches, [speed] * 100)
    last = CLOCK * float(switches.ticks[switches.numbers[0] % (EDGES + 1)])
    before = hall_speed(switches)
    for number in range(100, 4000):
        turn_hall(switches, number * PERIOD, PERIOD, 0.0)
        elapsed = (number + 1) * PERIOD - last
        longest = (60.0 + 2.0 * 1.0) * DEGREE / POLE_PAIRS
        assert hall_speed(switches) == pytest.approx(min(before, longest / elapsed), rel=1e-5)
    assert hall_speed(switches) < 0.5 * RPM * 1.1


def test_a_speed_that_no_switch_follows_leaves_things_as_they_are() -> None:
    switches = hall(speed=100.0)
    measured, errors = turn(switches, [1e300, math.nextafter(math.inf, 0.0)])
    assert (measured, errors) == ([100.0, 100.0], [0.0, 0.0])


def test_a_shaft_that_has_hardly_turned_is_at_rest() -> None:
    assert hall_speed(hall(speed=1e-300)) == 0.0
