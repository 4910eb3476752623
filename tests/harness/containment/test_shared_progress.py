"""Memory that a candidate's process shares with the harness, and may write over."""

import os

import pytest

from drivegate.containment.shared_memory import Activity, SharedProgress


@pytest.fixture
def progress():
    memory = SharedProgress.create()
    yield memory
    memory.close()


def test_each_activity_is_read_as_it_was_written(progress):
    assert progress.activity is Activity.STARTING
    for activity in Activity:
        before = progress.state
        progress.enter(activity)
        assert progress.activity is activity
        assert progress.state != before, "the worker has moved on"


def test_what_a_candidate_has_written_over_it_is_the_candidate_running(progress):
    os.pwrite(progress.descriptor, b"garbage" * 3, 0)
    assert progress.activity is Activity.RUNNING
