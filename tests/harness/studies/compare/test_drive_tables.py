"""The tables of a comparison of drives, on figures made up for them."""

from math import pi

import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.contracts.comparison import ComparisonRequest
from drivegate.contracts.current.comparison.plan import EFFORTS, planned_runs
from drivegate.studies.compare.compared_drive import ComparedDrive
from drivegate.studies.compare.drive_comparison import operating_points, summary_rows
from drivegate.studies.compare.engine import Compared
from drivegate.studies.compare.ranking import rows_of
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.drive_cycle import load_drive_cycle

CYCLE = load_drive_cycle("ece-15")
PAPER, FAN = load_drive("paper-5-phase"), load_drive("fan-3-phase")
LABELS = ("paper", "fan")


def figures(planned, held=True):
    """Take 10 % more than the load, 4 % of it in torque."""
    load = planned.scenario.load.torque_nm
    return {
        "held": held,
        "speed_mean_rpm": planned.speed_rpm,
        "torque_mean_nm": 1.04 * load,
        "input_power_w": 1.1 * load * planned.speed_rpm * pi / 30.0,
        "current_sum_a": 13.0,
        "ripple_percent": 10.0 * planned.share,
    }


def compared_on(drive, lost=()):
    request = ComparisonRequest(drive, "quick", 0, CYCLE)
    plan = planned_runs(request)
    one = Compared("one", "one", resolve_candidate("initial"))
    points = [(index, planned) for index, planned in enumerate(plan) if planned.group == "points"]
    for place, (index, planned) in enumerate(points):
        one.figures[index] = figures(planned, place not in lost)
    return ComparedDrive(request, plan, [one], {})


@pytest.fixture(scope="module")
def made():
    # The last point is full load at overspeed, the first the lightest load at the lowest speed.
    return [compared_on(PAPER, lost={15}), compared_on(FAN, lost={0})]


@pytest.fixture(scope="module")
def table(made):
    return operating_points(LABELS, made)


@pytest.fixture(scope="module")
def points(table):
    return rows_of(table)


def test_losses_are_split_at_the_torque(points):
    row = next(row for row in points if row["drive"] == "paper" and row["load_percent"] == 100.0)
    assert row["torque_pu"] == pytest.approx(500.0 / 550.0, rel=1e-4)
    assert row["shaft_power_w"] == pytest.approx(1500.0, rel=1e-4), "the load's torque is rounded"
    assert row["losses_pu"] == pytest.approx(0.1, rel=1e-4)
    assert row["electrical_losses_pu"] == pytest.approx(0.06, rel=1e-3)
    assert row["mechanical_losses_pu"] == pytest.approx(0.04, rel=1e-3)
    assert row["losses_w"] == pytest.approx(row["electrical_losses_w"] + row["mechanical_losses_w"])
    assert row["efficiency_percent"] == pytest.approx(100.0 / 1.1)
    assert row["current_sum_pu"] == pytest.approx(0.1)


def test_what_is_not_held_has_no_losses(points):
    lost = [row for row in points if not row["held"]]
    assert [(row["drive"], row["speed_pu"]) for row in lost] == [("paper", 4.0), ("fan", 1.1)]
    assert {row["losses_w"] for row in lost} == {None}
    assert {row["efficiency_percent"] for row in lost} == {None}


def test_means_are_over_the_points_held_on_every_drive(made, table):
    paper, fan = summary_rows(LABELS, made, table)
    assert (paper["points_held"], fan["points_held"]) == (15, 15)
    assert paper["points_shared"] == fan["points_shared"] == 14
    # 16 points of 62.5 % of rated power in the mean, less one of 100 % and one of 25 %.
    assert paper["losses_pu"] == pytest.approx(0.1 * (16 * 0.625 - 1.25) / 14, rel=1e-3)
    assert fan["losses_pu"] == pytest.approx(paper["losses_pu"], rel=2e-3)
    assert paper["efficiency_percent"] == pytest.approx(100.0 / 1.1)


def test_rated_power_is_held_up_to_the_first_gap(made, table):
    paper, fan = summary_rows(LABELS, made, table)
    assert (paper["rated_power_held_up_to_rpm"], paper["rated_power_held_up_to_pu"]) == (1500.0, 3.0)
    assert fan["rated_power_held_up_to_rpm"] == 8000.0


def test_points_of_a_narrow_range_that_are_one_speed_stand_for_every_share():
    narrow = PAPER.replaced(overspeed_rpm=PAPER.rating.highest_speed_rpm)
    rows = rows_of(operating_points(("narrow",), [compared_on(narrow)]))
    size = EFFORTS["quick"]
    assert len(rows) == len(size.speeds) * len(size.shares)
    assert {row["speed_rpm"] for row in rows if row["speed_share"] >= 1.0} == {1500.0}


def test_where_nothing_ran_the_drives_are_still_put_side_by_side():
    made = [compared_on(drive) for drive in (PAPER, FAN)]
    for one in made:
        one.all_compared[0].figures.clear()
    rows = summary_rows(LABELS, made, operating_points(LABELS, made))
    assert [(row["points"], row["points_shared"], row["losses_pu"]) for row in rows] == [(0, 0, None)] * 2
