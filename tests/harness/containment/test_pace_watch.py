"""When a run is reported to take long, and how long."""

import pytest

from drivegate.containment.watches import PaceWatch, SlowRun

HOUR = 3600.0


def stated(looks, steps=60_000, allowed=180.0):
    """Look at a run at several times, each with the number of steps begun; give all that is reported."""
    watch = PaceWatch(steps, allowed)
    return [slow for now, begun in looks if (slow := watch.slow(begun, now)) is not None]


def test_a_slow_run_is_reported_once_with_its_projection():
    (slow,) = stated([(10.0, 2), (12.0, 22), (14.0, 42), (16.0, 62), (60.0, 500)])
    assert slow == SlowRun(60_000, 0.1, 180.0)
    assert slow.seconds == pytest.approx(6000.0)


@pytest.mark.parametrize(
    "looks",
    [
        [(0.0, 2), (4.0, 4002), (9.0, 9002)],
        [(0.0, 0), (HOUR, 1)],
        [(0.0, 2), (HOUR, 2)],
        [(0.0, 2), (3.9, 3)],
    ],
    ids=["a millisecond a step", "the first step takes long", "one step hangs", "too early to know"],
)
def test_what_is_fast_or_not_known_yet_is_not_reported(looks):
    assert stated(looks) == []


def test_what_is_not_ended_as_a_hang_is_reported_from_one_minute_on():
    looks = [(0.0, 2), (4.0, 1002)]
    assert stated(looks, steps=14_900, allowed=2 * HOUR) == []
    assert stated(looks, steps=15_100, allowed=2 * HOUR)[0].seconds == pytest.approx(60.4)


def test_the_count_of_the_run_before_is_not_taken_for_its_own():
    looks = [(0.0, 60_000), (5.0, 2), (9.0, 42)]
    assert stated(looks)[0].step_seconds == pytest.approx(0.1)
