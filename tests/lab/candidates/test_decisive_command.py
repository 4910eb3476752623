"""Figures mark the command of a faulty controller that decides the check."""

import numpy as np
import pytest

from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.messages import JudgedCandidate
from drivegate.contracts.catalogue import check_of
from drivegate.drives.running import recorded
from drivegate_cases.scenario.scenario import load_scenario


@pytest.mark.parametrize(
    ("check", "fault", "column"),
    [
        ("ADV-1", "advance-below-base", "advance_deg"),
        ("ADV-2", "angle-unclamped", "advance_deg"),
        ("CMD-1", "current-limit-exceeded", "current_reference_a"),
    ],
)
def test_figures_show_the_command_that_decides(check, fault, column):
    scenario = load_scenario("fig5-search").replaced(duration_s=0.4, initial_speed_rpm=0.0)
    controller = load_controller(resolve_candidate(f"faulty:{fault}"))
    loaded = JudgedCandidate(resolve_candidate("reference"), lambda: controller)
    record = recorded(loaded, scenario, controller, trace_every=1)
    moment = check_of("current", check).moment(record)
    assert moment.column == column
    assert moment.end_s - moment.start_s < 0.3, "a part of the run"
    assert moment.start_s <= moment.point.time_s <= moment.end_s
    trace = record.run.trace
    shown = trace[column][np.searchsorted(trace["time_s"], moment.point.time_s)]
    assert moment.point.value == shown
    assert {mark.value for mark in moment.levels} <= {0.0, 90.0, 26.0}
    if check == "ADV-1":
        assert moment.point.value > 0.0
