"""The plan of a comparison: the same for every candidate, fair, and fixed by its seed."""

import pytest

from drivegate.contracts.comparison import ComparisonRequest
from drivegate.contracts.current.comparison.plan import EFFORTS, planned_runs
from drivegate.contracts.current.scenarios.feasibility import is_fair
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.drive_cycle import load_drive_cycle

DRIVE, CYCLE = load_drive("paper-5-phase"), load_drive_cycle("ece-15")


def planned(effort, seed):
    return planned_runs(ComparisonRequest(DRIVE, effort, seed, CYCLE))


@pytest.fixture(scope="module")
def plan():
    return planned("quick", 0)


def test_the_plan_has_what_the_effort_says(plan):
    size = EFFORTS["quick"]
    counts = {group: sum(run.group == group for run in plan) for group in ("points", "disturbances", "drawn")}
    assert counts == {
        "points": len(size.speeds) * len(size.shares),
        "disturbances": size.disturbances,
        "drawn": size.drawn,
    }
    cycles = [run for run in plan if run.group == "cycle"]
    assert [run.seed for run in cycles] == [None, *range(size.noise_seeds)]
    assert len({run.scenario.seed for run in cycles}) == len(cycles), "every repetition has noise of its own"


def test_everything_steady_can_be_done_at_some_angle(plan):
    for run in plan:
        if run.group in ("points", "noise", "drawn"):
            assert is_fair(run.scenario), f"no angle can do {run.label}"


def test_the_same_seed_gives_the_same_plan(plan):
    assert planned("quick", 0) == plan
    other = planned("quick", 1)
    drawn = [[run.scenario for run in made if run.group == "drawn"] for made in (plan, other)]
    assert drawn[0] != drawn[1]
    fixed = [[run.scenario for run in made if run.group == "points"] for made in (plan, other)]
    assert fixed[0] == fixed[1]


def test_a_greater_effort_keeps_what_a_smaller_one_draws(plan):
    more = planned("default", 0)
    drawn = [[run.scenario for run in made if run.group == "drawn"] for made in (plan, more)]
    assert drawn[1][: len(drawn[0])] == drawn[0]
