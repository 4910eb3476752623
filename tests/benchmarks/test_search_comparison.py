"""The comparison of searches compares what it says: equal allowances, seeds alone, and known shares of failures."""

import json
from collections.abc import Callable
from math import dist
from pathlib import Path
from statistics import median
from typing import Any

import pytest

from rare_severities import rareness
from search_comparison import known_cells
from search_figure import found_share, levels_near_the_best, tables
from search_methods import INSTALLED, METHODS, SHARD_ALLOWANCE, Trial, random_points
from search_trials import COMPARED, LEVELS, SEEDS, expected_draws, first_in_pockets
from weakened_faults import FAULTS
from weakening import GRID, Judge, Point, WeakenedFault, correct, on_grid

MIDDLE = (0.3, 0.7, 0.6)
GRADUAL = [fault for fault in FAULTS if fault.shape == "gradual"]
FLAT = [fault for fault in FAULTS if fault.shape == "flat"]
SUDDEN = [fault for fault in FAULTS if fault.shape == "sudden"]


def bowl(point: Point) -> float:
    return dist(point, MIDDLE)


def runs_of(
    method: str, seed: int, allowance: int = 60, margin: Callable[[Point], float] = bowl
) -> list[Point]:
    trial = Trial(margin, allowance)
    METHODS[method](trial, len(MIDDLE), seed)
    return trial.points


@pytest.mark.one_in(4)
@pytest.mark.parametrize("method", INSTALLED)
def test_a_method_makes_its_allowance_of_new_runs_and_follows_its_seed(method: str) -> None:
    points = runs_of(method, 1)
    assert len(points) == len(set(points))
    allowed = SHARD_ALLOWANCE if method.endswith("-briefly") else 60
    assert len(points) == allowed, f"{method} made {len(points)} runs of {allowed}"
    assert points == runs_of(method, 1), f"{method} depends on more than its seed"
    assert points != runs_of(method, 2), f"{method} does not depend on its seed"


@pytest.mark.parametrize(
    "method",
    [method for method in INSTALLED if method not in ("drawing", "climbing-briefly", "uniform", "annealing")],
)
def test_what_climbs_comes_closer_than_even_drawing(method: str) -> None:
    even = Trial(bowl, 150)
    random_points(even, len(MIDDLE), 3)
    least = min(map(bowl, runs_of(method, 3, 150)))
    assert least < 0.5 * min(map(bowl, even.points)), f"{method} comes to {least:.3f}"


def test_a_simplex_starts_again_where_it_has_converged() -> None:
    near, far = (0.9, 0.1, 0.2), (0.1, 0.9, 0.9)
    trial = Trial(lambda point: min(dist(point, near) + 0.1, dist(point, far) - 0.1), 300)
    METHODS["simplex"](trial, 3, 2)
    assert near in trial.points, "it did not converge in the bowl without a failure first"
    assert trial.found


def test_a_trial_ends_at_the_first_failure() -> None:
    trial = Trial(lambda point: point[0] - 0.5, 1000)
    random_points(trial, 3, 0)
    assert trial.found
    assert [place for place, *_ in trial.points if place < 0.5] == [trial.points[-1][0]]


def test_points_lie_on_the_grid_inside_the_cube() -> None:
    assert on_grid((-0.2, 1.7, 0.12345)) == (0.0, 1.0, 123 / GRID)


@pytest.mark.nightly
@pytest.mark.parametrize("fault", SUDDEN, ids=lambda fault: fault.name)
def test_a_pocket_takes_up_the_share_that_its_level_says(fault: WeakenedFault) -> None:
    share = 1.0 / expected_draws(0)
    trial = Trial(lambda _point: 1.0, 40_000)
    random_points(trial, len(fault.cube.coordinates), 5)
    inside = sum(fault.distance(point) <= fault.half_width(share) for point in trial.points)
    assert inside / 40_000 == pytest.approx(share, rel=0.2)


@pytest.mark.parametrize("fault", SUDDEN, ids=lambda fault: fault.name)
def test_a_sudden_fault_shows_everywhere_in_its_pocket(fault: WeakenedFault) -> None:
    # Else no search can find what even drawing is said to find.
    assert fault.pocket is not None
    points = Trial(lambda _point: 1.0, 4)
    random_points(points, len(fault.cube.coordinates), 7)
    half_width = fault.half_width(1.0 / expected_draws(0))
    faulty, right = Judge(fault.at(1.0), fault.check, fault.cube), correct(fault.check, fault.cube)
    for point in points.points:
        moved = {
            number: min(max(centre + (2.0 * point[number] - 1.0) * half_width, 0.0), 1.0)
            for number, centre in fault.pocket.items()
        }
        inside = on_grid(tuple(moved.get(number, place) for number, place in enumerate(point)))
        assert faulty.margin(inside) < 0.0, f"{fault.check} misses the fault at {inside}"
        assert right.margin(inside) >= 0.0, f"{fault.check} accuses the correct controller at {inside}"


@pytest.mark.parametrize("fault", SUDDEN, ids=lambda fault: fault.name)
def test_a_sudden_fault_is_caught_in_its_pocket_alone(fault: WeakenedFault) -> None:
    assert fault.pocket is not None
    middle = tuple(fault.pocket.get(place, 0.5) for place in range(len(fault.cube.coordinates)))
    away = tuple((place + 0.5) % 1.0 for place in middle)
    first = first_in_pockets(fault, [away, middle])
    assert first == [2] * len(first), f"the pocket of each level is met in the second run, not in {first}"


@pytest.mark.parametrize("fault", [*GRADUAL, *FLAT], ids=lambda fault: fault.name)
def test_a_gradual_fault_grows_from_nothing(fault: WeakenedFault) -> None:
    points = Trial(lambda _point: 1.0, 6)
    random_points(points, len(fault.cube.coordinates), 11)
    least = {
        severity: min(map(Judge(fault.at(severity), fault.check, fault.cube).margin, points.points))
        for severity in (0.0, 1.0)
    }
    right = min(map(correct(fault.check, fault.cube).margin, points.points))
    assert right >= 0.0, f"the correct controller is accused by {fault.check}"
    assert least[0.0] >= 0.0, "the weakest fault is caught nearly everywhere"
    assert least[1.0] < least[0.0], "the fault does not grow"


def _spread(fault: WeakenedFault, severity: float) -> float:
    """Return the range of the lesser margins: those of runs in which the fault shows at all."""
    points = Trial(lambda _point: 1.0, 24)
    random_points(points, len(fault.cube.coordinates), 5)
    margins = list(map(Judge(fault.at(severity), fault.check, fault.cube).margin, points.points))
    lesser = [margin for margin in margins if margin < 0.9]
    return max(lesser) - min(lesser)


def test_margins_of_a_flat_fault_do_not_differ() -> None:
    # Each at a severity at which one draw in ten thousand fails.
    assert _spread(FLAT[0], 0.76) < 0.05
    assert _spread(GRADUAL[0], 0.464) > 0.2
    assert _spread(GRADUAL[1], 0.585) > 0.2


def test_rare_failures_are_as_rare_as_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    class Corner:
        """Fails within a severity of a corner of its cube: a share of severity³."""

        name = "corner"
        check = ""

        class cube:
            coordinates = ((), (), ())

        def at(self, severity: float) -> float:
            return severity

    class MaximumJudge:
        def __init__(self, severity: float, _check: str, _cube: object) -> None:
            self._severity = severity

        def margin(self, point: Point) -> float:
            return max(point) - self._severity

    monkeypatch.setattr("rare_severities.Judge", MaximumJudge)
    found = [rareness(Corner(), 1e-4, size=40, number=number) for number in range(8)]  # type: ignore[arg-type]
    for share in (1e-1, 1e-2, 1e-3):
        shares = [one.severity(share) ** 3 for one in found]
        assert median(shares) == pytest.approx(share, rel=0.3), f"{shares} at a share of {share}"


def test_shares_have_errors_and_medians_are_compared() -> None:
    fault = GRADUAL[0]
    # The shard needs 20 runs with every other seed, and each other method 10 at half of the levels.
    cells = {
        f"{fault.name}/{method}/{level}/{seed}": {
            "runs": 20 if method == "shard" else 10,
            "found": seed % 2 == 0 if method == "shard" else level % 2 == 0,
        }
        for method in COMPARED
        for level in range(LEVELS)
        for seed in SEEDS
    }
    assert str(found_share(cells, fault, "shard", 20)) == "50 ± 23 %"
    assert str(found_share(cells, fault, "shard", 19)) == "0 ± 0 %"
    assert found_share(cells, fault, "covariance", 10).value == 0.5
    # Half of the seeds find nothing: the shard's median is infinite, as that of the others is at odd levels.
    assert levels_near_the_best(cells, fault) == (0, LEVELS // 2)
    for key in [key for key in cells if "/shard/" in key]:
        cells[key] = {"runs": 15, "found": True}
    assert levels_near_the_best(cells, fault) == (LEVELS, LEVELS)


def test_tables_have_both_contracts_and_the_methods_whose_trials_were_made() -> None:
    def cell(fault: WeakenedFault) -> dict[str, Any]:
        # One is found in the 40th run, a gradual one in that contract alone whose drive comes last.
        is_found = fault.cube.drive.name == FAULTS[-1].cube.drive.name
        sized = {"runs": 40, "found": is_found, "seconds": 1.0}
        return {"first": [40] * LEVELS, "seconds": 1.0} if fault.shape == "sudden" else sized

    cells = {
        f"{fault.name}/{method}/{level}/{seed}": cell(fault)
        for fault in FAULTS
        for method in ("drawing", "climbing", "climbing-briefly", "shard")
        for level in ((-1,) if fault.shape == "sudden" else range(LEVELS))
        for seed in SEEDS
    }
    written = tables(cells)
    assert (
        "| even drawing | Hypothesis, drawing | Hypothesis, target | as a shard of the gate | levels |"
        in written
    )
    rows = {row.split("|")[1].strip(): row.split("|")[6:-2] for row in written.splitlines() if "|" in row}
    for row, share in {
        "*all gradual ones of `paper-5-phase`*": "0 ± 0 %",
        "*all gradual ones of `pm-ac-interior`*": "100 ± 0 %",
        "*all gradual ones of `pm-ac-interior`, first 36 runs*": "0 ± 0 %",
        "*all sudden ones of `paper-5-phase`*": "100 ± 0 %",
    }.items():
        assert rows[row][-1].strip().startswith(share.removesuffix(" %")), f"{row}: {rows[row]}"


def test_trials_of_one_method_are_made_again_alone(tmp_path: Path) -> None:
    kept = {"fault": {}, "fault/shard/0/0": {}, "fault/drawing/0/0": {}}
    result = tmp_path / "result.json"
    assert known_cells(result, None) == {}
    result.write_text(json.dumps({"cells": kept}))
    assert known_cells(result, None) == kept
    assert set(known_cells(result, "shard")) == {"fault", "fault/drawing/0/0"}
    assert known_cells(result, "all") == {}
