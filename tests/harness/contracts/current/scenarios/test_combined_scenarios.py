"""Joint changes: every possible pair of levels is in some row, and every row becomes a fair run that shows it."""

import subprocess
import sys
from itertools import combinations, pairwise

import pytest

from drivegate.contracts.current.run import observed_windows
from drivegate.contracts.current.scenarios.combined import (
    combined_scenarios,
    long_scenarios,
)
from drivegate.contracts.current.scenarios.feasibility import is_fair
from drivegate.scenarios.covering import FACTORS, IMPOSSIBLE, covering_rows, is_possible, possible_pairs
from drivegate.scenarios.drive_scale import scale_of
from drivegate_cases.drive.drive_document import load_drive

DRIVE = load_drive("paper-5-phase")


def test_every_possible_pair_of_levels_is_in_some_row() -> None:
    rows = covering_rows()
    covered = {frozenset(pair) for row in rows for pair in combinations(row.items(), 2)}
    missing = [dict(pair) for pair in possible_pairs() if pair not in covered]
    assert not missing, f"no row has {missing[0]}"
    assert all(is_possible(list(row.values())) for row in rows)
    assert not covered & set(IMPOSSIBLE)


def test_what_is_impossible_is_of_levels_that_there_are() -> None:
    unknown = [
        (factor, level) for pair in IMPOSSIBLE for factor, level in pair if level not in FACTORS[factor]
    ]
    assert not unknown


def test_the_rows_are_the_same_in_every_process() -> None:
    """Whatever Python's own seed of texts' hashes is."""
    code = "from drivegate.scenarios.covering import covering_rows; print(covering_rows())"
    printed = [
        subprocess.run(
            [sys.executable, "-c", code],
            env={"PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("1", "2")
    ]
    assert printed[0] == printed[1] == f"{covering_rows()}\n"


@pytest.mark.one_in(2)
@pytest.mark.parametrize("seed", [0, 1])
def test_every_row_becomes_a_fair_run_that_can_be_judged(seed: int) -> None:
    scenarios = combined_scenarios(DRIVE, None, seed)
    of_rows = len(scenarios) - len(long_scenarios(DRIVE, None, seed))
    assert of_rows == len(covering_rows()), "a row has no fair scenario"
    for scenario in scenarios:
        assert is_fair(scenario), scenario.description
        assert observed_windows(scenario), f"{scenario.name} is never judged"


@pytest.mark.nightly
def test_parts_make_the_whole_whatever_their_number() -> None:
    def contents(parts: int) -> set[str]:
        return {
            scenario.to_json()
            for part in range(parts)
            for scenario in combined_scenarios(DRIVE, None, 3, part, parts)
        }

    assert contents(1) == contents(8)
    assert contents(1) != {scenario.to_json() for scenario in combined_scenarios(DRIVE, None, 4)}


def test_long_runs_last_minutes_at_rated_power() -> None:
    for scenario in long_scenarios(DRIVE, None, 0):
        assert scenario.duration_s >= scale_of(DRIVE).long_s >= 120.0
        power = scenario.load.torque_nm * scenario.speed_rpm[0][1] * 0.10471975512  # type: ignore[union-attr]
        assert power == pytest.approx(DRIVE.rating.rated_power_w, rel=1e-3)
        assert scenario.load_profile[1] == (0.2, 1.0)


def test_a_long_run_leaves_the_search_time_to_rest_between_more_than_twenty_changes() -> None:
    *_, busy = long_scenarios(DRIVE, None, 0)
    changes = [
        time
        for (time, share), (_, after) in pairwise(busy.load_profile)
        if share != after and time > scale_of(DRIVE).load_ramp_s
    ]
    assert len(changes) > 20, busy.name
    assert min(after - before for before, after in pairwise(changes)) >= 6.0
    assert busy.name.endswith("-100-50×12-100%")


def test_no_two_rows_of_the_loaded_speeds_have_the_same_one() -> None:
    scenarios = combined_scenarios(DRIVE, None, 0)
    steady = [
        scenario.speed_rpm[0][1]
        for scenario in scenarios
        if len(scenario.speed_rpm) == 1
        and scenario.speed_rpm[0][1] <= 1500.0
        and scenario.duration_s < scale_of(DRIVE).long_s
    ]
    assert len(set(steady)) == len(steady) >= 8, sorted(steady)


def test_a_declared_speed_range_holds() -> None:
    for scenario in combined_scenarios(DRIVE, (700.0, 1200.0), 0):
        assert all(700.0 <= speed <= 1200.0 for _, speed in scenario.speed_rpm), scenario.name
