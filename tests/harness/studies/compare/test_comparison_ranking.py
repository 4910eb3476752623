"""The ranking's one rule, on operating points made up for it."""

import pytest
from tests.harness.made import made_outcome

from drivegate.candidates.fault import Fault, FaultKind
from drivegate.candidates.resolution import resolve_candidate
from drivegate.contracts.comparison import POINTS
from drivegate.contracts.current.comparison.declaration import COMPARISON
from drivegate.studies.compare.engine import Compared, labelled
from drivegate.studies.compare.ranking import difference_rows, ranking_rows, region_rows
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.errors import InputError

PLACES = ((700.0, 25.0), (700.0, 100.0), (1500.0, 100.0))


def compared(label, *, failed=None, **others):
    made = Compared(label, label, resolve_candidate("initial"), **others)
    if failed is not None:
        made.outcomes = tuple(check(f"CNV-{number}") for number in range(failed))
    return made


def check(identifier, *, verdict="fail", level="required"):
    return made_outcome(identifier, verdict, level=level, margin=-1.0)


def points(label, watts, held=(True, True, True)):
    return [
        {
            "candidate": label,
            "speed_rpm": speed,
            "load_percent": load,
            "feasible": True,
            "held": is_held,
            "input_power_w": power,
            "current_sum_a": power / 40.0,
            "gap_power_w": 1.0,
            "gap_current_percent": 2.0,
            "ripple_percent": 10.0,
            "converged_after_s": 1.0,
        }
        for (speed, load), power, is_held in zip(PLACES, watts, held, strict=True)
    ]


def ranked(everybody, rows):
    return ranking_rows(everybody, COMPARISON.ranking, {POINTS: rows})


def regions(everybody, rows, drive):
    labels = [made.label for made in everybody]
    return region_rows(labels, rows, COMPARISON.region_ends_rpm(drive), COMPARISON.ranking.costs)


def places(rows):
    return [(row["rank"], row["candidate"]) for row in rows]


def test_fewer_failed_checks_come_before_watts():
    rows = ranked(
        [compared("thrifty", failed=1), compared("correct", failed=0)],
        points("thrifty", (100.0, 400.0, 400.0)) + points("correct", (200.0, 800.0, 800.0)),
    )
    assert places(rows) == [(1, "correct"), (2, "thrifty")]
    assert rows[1]["power_above_first_w"] == pytest.approx(-300.0)
    assert rows[1]["failed_checks"] == "CNV-0"


def test_points_held_come_before_watts():
    rows = ranked(
        [compared("loses"), compared("holds")],
        points("loses", (1.0, 1.0, 1.0), (True, True, False)) + points("holds", (200.0, 800.0, 800.0)),
    )
    assert places(rows) == [(1, "holds"), (2, "loses")]
    assert rows[1]["points_shared"] == 2
    assert rows[1]["input_power_w"] == pytest.approx(1.0)
    assert rows[1]["power_above_first_w"] == pytest.approx(-499.0), "only points that both hold are compared"


def test_equals_are_separated_by_watts_and_share_a_place_within_a_thousandth():
    rows = ranked(
        [compared("worse"), compared("best"), compared("nearly")],
        points("worse", (103.0, 400.0, 800.0))
        + points("best", (100.0, 400.0, 800.0))
        + points("nearly", (100.9, 400.0, 800.0)),
    )
    assert places(rows) == [(1, "best"), (1, "nearly"), (3, "worse")]


def test_identical_candidates_share_any_place():
    same = (103.0, 400.0, 800.0)
    rows = ranked(
        [compared("best"), compared("one"), compared("other"), compared("last")],
        points("best", (100.0, 400.0, 800.0))
        + points("one", same)
        + points("other", same)
        + points("last", (110.0, 400.0, 800.0)),
    )
    assert places(rows) == [(1, "best"), (2, "one"), (2, "other"), (4, "last")]


def test_faults_and_refusals_have_no_place():
    fault = Fault(FaultKind.CRASH, "died", "step")
    refused = Compared("refused", "refused", error=InputError("no such candidate"))
    rows = ranked(
        [refused, compared("faulted", faults=[fault]), compared("fine")],
        points("fine", (100.0, 400.0, 800.0)) + points("faulted", (1.0, 1.0, 1.0)),
    )
    assert places(rows) == [(1, "fine"), (None, "faulted"), (None, "refused")]
    assert [row["status"] for row in rows] == ["compared", "faulted", "refused"]
    assert rows[2]["input_power_w"] is None


def test_where_nothing_ran_there_are_no_figures():
    fault = Fault(FaultKind.CRASH, "died", "step")
    rows = ranked([compared("one", faults=[fault]), compared("other", faults=[fault])], [])
    assert places(rows) == [(None, "one"), (None, "other")]
    assert [(row["points_held"], row["points_feasible"], row["points_shared"]) for row in rows] == [
        (0, 0, 0)
    ] * 2
    assert {row["gap_power_w"] for row in rows} == {row["power_above_first_w"] for row in rows} == {None}


def test_only_who_holds_a_region_can_win_it():
    rows = regions(
        [compared("loses"), compared("holds")],
        points("loses", (1.0, 1.0, 1.0), (True, False, True)) + points("holds", (200.0, 800.0, 800.0)),
        load_drive("paper-5-phase"),
    )
    of = {(row["region"], row["candidate"]): row for row in rows}
    heavy = of["up to 800 rpm, half load and more", "loses"]
    assert (heavy["points_held"], heavy["input_power_w"]) == (0, None)
    assert of["up to 800 rpm, half load and more", "holds"]["power_above_best_w"] == 0.0
    assert of["up to 800 rpm, below half load", "holds"]["power_above_best_w"] == pytest.approx(199.0)
    assert len(of) == 6, "a region without operating points is left out"


def test_bands_of_speed_follow_from_the_drive():
    def bands(name):
        drive = load_drive(name)
        speeds = [share * drive.rating.base_speed_rpm for share in (1.5, 2.0, 3.0, 4.0)]
        one = points("any", (1.0, 1.0, 1.0))[0] | {"load_percent": 100.0}
        made = [one | {"speed_rpm": speed} for speed in speeds]
        return [row["region"] for row in regions([compared("any")], made, drive)]

    heavy = ", half load and more"
    paper = ["up to 800 rpm", "800 to 1200 rpm", "1200 to 1500 rpm", "above 1500 rpm"]
    assert bands("paper-5-phase") == [band + heavy for band in paper]
    fan = ["up to 3200 rpm", "3200 to 4800 rpm", "4800 to 6000 rpm", "above 6000 rpm"]
    assert bands("fan-3-phase") == [band + heavy for band in fan]


def test_equal_names_are_numbered():
    assert [made.label for made in labelled("abc", ["x", "x", "y"])] == ["x", "x (2)", "y"]


def test_pairs_are_matched_by_seed_and_lost_runs_are_counted():
    def drawn(label, watts, lost=()):
        return [
            {
                "candidate": label,
                "group": "drawn",
                "scenario": "any",
                "seed": seed,
                "held": seed not in lost,
                "input_power_w": power,
                "current_sum_a": power / 40.0,
            }
            for seed, power in enumerate(watts)
        ]

    runs = drawn("a", (100.0, 200.0, 300.0, 400.0)) + drawn("b", (110.0, 211.0, 312.0, 9.0), lost={3})
    rows = difference_rows(["a", "b"], COMPARISON.populations, {"repetitions": runs[::-1], "drive_cycle": []})
    power = next(row for row in rows if row["quantity"] == "input_power_w")
    assert (power["pairs"], power["left_out"]) == (3, 1)
    assert power["mean_difference"] == pytest.approx(-11.0)
    assert power["verdict"] == "a is lower"


def test_a_noisy_point_that_is_there_twice_is_paired_once():
    def noisy(label, watts):
        row = {"candidate": label, "group": "noise", "scenario": "same", "held": True, "current_sum_a": 1.0}
        return [row | {"seed": seed, "input_power_w": watts + seed} for seed in (0, 1, 2, 0, 1, 2)]

    runs = {"repetitions": noisy("a", 100.0) + noisy("b", 90.0), "drive_cycle": []}
    rows = difference_rows(["a", "b"], COMPARISON.populations, runs)
    (power,) = (row for row in rows if (row["where"], row["quantity"]) == ("same", "input_power_w"))
    assert (power["pairs"], power["left_out"], power["mean_difference"]) == (3, 0, 10.0)
