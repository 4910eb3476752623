"""Speeds at which Hall edges beat slowly with the control period: reported and seen to move Σ|i| without any search."""

import pytest

from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.contracts.current.scenarios.building import steady_scenario
from drivegate.contracts.current.scenarios.feasibility import beats_with_edges, unfair_because
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
from drivegate.drives.running import run_scenario
from drivegate.scenarios.changes import with_real_sensors, with_speed
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.scenario.scenario import Scenario

STAR = load_drive("star-3-phase")


def through_sensors(speed_rpm: float, drive: DriveDocument = STAR, share: float = 0.5) -> Scenario:
    return with_real_sensors(steady_scenario(drive, speed_rpm, power_share=share, constant_power=False), 0)


def test_eight_nine_and_ten_periods_in_a_cycle_beat_and_speeds_between_do_not() -> None:
    beating = {speed for speed in range(1050, 1400, 5) if beats_with_edges(through_sensors(float(speed)))}
    # 2000 control periods a second over 11 pole pairs and 10, 9 or 8 of them in a cycle.
    assert beating == {1090, 1095, 1210, 1215, 1360, 1365, 1370}


def test_a_speed_that_is_passed_does_not_count_and_one_that_is_held_does() -> None:
    run = through_sensors(1300.0)
    passing = with_speed(run, ((0.0, 1300.0), (4.0, 1300.0), (5.0, 1420.0)))
    held = with_speed(run, ((0.0, 1300.0), (4.0, 1300.0), (5.0, 1363.0)))
    assert not beats_with_edges(passing)
    assert beats_with_edges(held)


def test_only_hall_switches_give_a_commutation_that_beats() -> None:
    ideal = steady_scenario(STAR, 1363.0, power_share=0.5, constant_power=False)
    encoder = through_sensors(1363.0, load_drive("paper-5-phase"))
    assert not beats_with_edges(ideal)
    assert not beats_with_edges(encoder)


def test_nobody_is_judged_by_such_a_run_and_no_fixed_one_is_such() -> None:
    reason = unfair_because(through_sensors(1363.0))
    assert reason is not None
    assert "Hall edges" in reason
    assert unfair_because(through_sensors(1350.0)) is None
    assert not [run.name for run in fixed_scenarios(STAR) if beats_with_edges(run)]


@pytest.mark.parametrize("beating", [1092.0, 1213.0, 1363.0])
def test_the_current_sum_moves_at_a_fixed_angle_at_such_a_speed_alone(beating: float) -> None:
    """`initial` searches nothing, so what moves Σ|i| is not the candidate."""
    swings = {}
    for speed in (beating, beating + 20.0):
        run = run_scenario(through_sensors(speed), load_controller(resolve_candidate("initial")))
        means = run.windows[-1]
        swings[speed] = means.current_sum_range / means.current_sum
    assert swings[beating] > 2.0 * swings[beating + 20.0], swings
