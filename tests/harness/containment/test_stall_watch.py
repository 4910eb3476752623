"""When a worker counts as hanging."""

import pytest

from drivegate.containment.shared_memory import Activity
from drivegate.containment.watches import StallWatch, WorkerLimits

LIMITS = WorkerLimits(
    step_processor_seconds=5.0, start_processor_seconds=120.0, idle_seconds=60.0, order_seconds=1000.0
)
RESET, FIRST, LATER = (3, 0), (3, 1), (3, 7)


def after(state, activity, processor, now):
    """Look at a worker that has not moved since it had used 10 s of processor time at the clock's 100 s."""
    watch = StallWatch(LIMITS, processor=10.0, now=100.0)
    assert watch.stalled(state, activity, 10.0, 100.0) is None
    return watch.stalled(state, activity, 10.0 + processor, 100.0 + now)


@pytest.mark.parametrize(
    ("state", "activity", "processor", "now", "reason"),
    [
        (LATER, Activity.RUNNING, 4.9, 5.0, None),
        (LATER, Activity.RUNNING, 5.1, 5.2, "no progress within 5 s of processor time"),
        (FIRST, Activity.RUNNING, 119.0, 119.0, None),
        (FIRST, Activity.RUNNING, 121.0, 121.0, "no progress within 120 s of processor time"),
        (RESET, Activity.RUNNING, 121.0, 121.0, "no progress within 120 s of processor time"),
        (LATER, Activity.PREPARING, 119.0, 119.0, None),
        (FIRST, Activity.LOADING, 121.0, 121.0, "no progress within 120 s of processor time"),
        (LATER, Activity.RUNNING, 0.1, 59.0, None),
        (LATER, Activity.RUNNING, 0.1, 61.0, "no progress within 60 s of waiting"),
        (FIRST, Activity.LOADING, 0.1, 61.0, "no progress within 60 s of waiting"),
        (FIRST, Activity.LOADING, 4.0, 61.0, None),
        (FIRST, Activity.LOADING, 4.0, 1001.0, "the run did not end within 1000 s"),
    ],
)
def test_a_worker_that_does_not_move_is_given_its_allowance(state, activity, processor, now, reason):
    assert after(state, activity, processor, now) == reason


def test_every_step_renews_the_allowance():
    watch = StallWatch(LIMITS, processor=0.0, now=0.0)
    reasons = {watch.stalled((1, step), Activity.RUNNING, 4.0 * step, 50.0 * step) for step in range(1, 20)}
    assert reasons == {None}


def test_a_run_that_moves_forever_still_ends():
    watch = StallWatch(LIMITS, processor=0.0, now=0.0)
    assert watch.stalled((1, 5), Activity.RUNNING, 1.0, 1001.0) == "the run did not end within 1000 s"
