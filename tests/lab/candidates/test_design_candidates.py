"""Correct controllers of other designs: they are found by name, and each finds the optimum its own way."""

import pytest

from drivegate.candidates.declaration import Declaration
from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.margin import Margin
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate.contracts.current.checks.convergence import window_convergence
from drivegate.contracts.current.record import CurrentRecord
from drivegate.contracts.current.scenarios.building import steady_scenario
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
from drivegate.drives.running import run_scenario
from drivegate.scenarios.changes import with_beginning, with_load_factor, with_load_shares, with_real_sensors
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario, load_scenario
from drivegate_lab.candidates.families import DESIGN_NAMES
from drivegate_lab.candidates.faults.tolerances import NEAR_DESIGNS
from drivegate_lab.selftest.subjects import correct_designs
from drivegate_models.errors import InputError

DESIGN_CANDIDATES = [f"design:{name}" for name in DESIGN_NAMES]

HARD = ("lock-up", "900rpm-1500W-50-100%", "700rpm-1500W-L×1.2", "700rpm-1500W-mcs96")


def failed_margins(name: str, scenario: Scenario) -> list[Margin]:
    """Run a design, and return what it fails of the required checks."""
    candidate = resolve_candidate(name)
    run = run_scenario(scenario, load_controller(candidate))
    record = CurrentRecord(scenario, run, candidate.declaration)
    margins = [check.evaluate(record) for check in CHECKS if check.level == "required"]
    return [margin for margin in margins if margin is not None and not margin.met and not margin.advisory]


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", DESIGN_CANDIDATES)
@pytest.mark.parametrize("scenario_name", HARD)
def test_a_design_rests_at_the_optimum(name: str, scenario_name: str) -> None:
    (scenario,) = (
        scenario
        for scenario in fixed_scenarios(load_drive("paper-5-phase"))
        if scenario.name == scenario_name
    )
    failed = failed_margins(name, scenario)
    assert not failed, failed


@pytest.mark.parametrize("name", DESIGN_CANDIDATES)
@pytest.mark.parametrize("share", [0.95, 0.9])
def test_a_load_a_little_lighter_during_the_search_does_not_mislead_a_design(name: str, share: float) -> None:
    steady = steady_scenario(load_drive("paper-5-phase"), 1210.0, power_share=1.0, constant_power=True)
    failed = failed_margins(name, with_load_shares(steady, (0.0, 0.95), (1.5, 1.0), (3.5, share)))
    assert not failed, failed


def test_a_table_is_looked_up_again_where_a_load_that_grows_has_pushed_the_angle_too_far() -> None:
    steady = steady_scenario(load_drive("fan-3-phase"), 4750.0, power_share=1.0, constant_power=True)
    growing = with_load_factor(steady, ((0.0, 0.0), (0.2, 0.65), (6.0, 0.65), (7.6, 0.8)))
    failed = failed_margins("design:angle-table", growing)
    assert not failed, failed


def test_a_fine_sweep_is_given_up_where_the_load_changes_meanwhile() -> None:
    steady = steady_scenario(load_drive("fan-3-phase"), 5600.0, power_share=1.0, constant_power=False)
    changing = with_load_shares(steady, (0.0, 0.55), (5.5, 1.0), (6.7, 0.55))
    failed = failed_margins("design:sweep", changing)
    assert not failed, failed


def test_an_edge_that_a_long_stride_has_shown_is_looked_for_again_by_small_ones() -> None:
    steady = steady_scenario(load_drive("fan-3-phase"), 5900.0, power_share=1.0, constant_power=True)
    failed = failed_margins("design:quadratic-interpolation", steady)
    assert not failed, failed


@pytest.mark.nightly
def test_a_search_has_its_time_from_the_moment_on_at_which_the_load_changes() -> None:
    steady = steady_scenario(load_drive("star-24v-3-phase"), 5350.0, power_share=1.0, constant_power=False)
    changing = with_load_shares(steady, (0.0, 0.8), (3.5, 1.0), (4.9, 0.8))
    beginning = with_beginning(changing, control_period_s=1e-4, clock_start_s=60.0, initial_angle_deg=144.0)
    failed = failed_margins("design:quadratic-interpolation", beginning)
    assert not failed, failed


def test_at_light_load_a_design_takes_the_angle_of_the_table() -> None:
    steady = steady_scenario(load_drive("paper-5-phase"), 1430.0, power_share=0.3, constant_power=True)
    seen = steady.replaced(sensors={"kind": "mcs96"})
    digests = {
        name: run_scenario(seen, load_controller(resolve_candidate(name))).digest
        for name in DESIGN_CANDIDATES
    }
    assert len(set(digests.values())) == 1, digests
    assert not failed_margins("design:angle-table", seen)


def test_a_design_does_not_rest_where_regulator_and_band_beat() -> None:
    steady = steady_scenario(load_drive("paper-5-phase"), 1460.0, power_share=0.1, constant_power=True)
    failed = failed_margins("design:quadratic-interpolation", steady)
    assert not failed, failed


@pytest.mark.one_in(4)
@pytest.mark.parametrize("name", DESIGN_CANDIDATES)
def test_a_design_does_not_rest_where_the_current_sum_swings_within_a_step_of_the_encoder(name: str) -> None:
    steady = steady_scenario(load_drive("paper-5-phase"), 1440.0, power_share=1.0, constant_power=False)
    controller = load_controller(resolve_candidate(name))
    margins = {}
    for seed in (*range(12), 158):
        seen = with_real_sensors(with_load_shares(steady, (0.0, 0.7), (10.0, 0.1)), seed)
        record = CurrentRecord(seen, run_scenario(seen, controller), Declaration())
        margins[seed], _ = window_convergence(list(record.windows())[-1])
    assert min(margins.values()) >= 0.0, f"{name} rests where Σ|i| swings beyond the limit: {margins}"
    swinging = [seed for seed, margin in margins.items() if margin < 0.5]
    assert len(swinging) <= 1, f"{name} rests where Σ|i| swings by half the limit at the seeds {swinging}"


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["design:golden-section", "design:sweep"])
def test_a_design_at_rest_does_not_take_the_noise_of_hall_switches_for_the_edge(name: str) -> None:
    steady = steady_scenario(load_drive("star-3-phase"), 1360.0, power_share=1.0, constant_power=False)
    failed = failed_margins(name, with_real_sensors(steady, 0))
    assert not failed, failed


def test_designs_move_differently() -> None:
    scenario = load_scenario("fig5-search")
    digests = {
        name: run_scenario(scenario, load_controller(resolve_candidate(name))).digest
        for name in ("reference", *DESIGN_CANDIDATES)
    }
    assert len(set(digests.values())) == len(digests), digests


def test_an_unknown_design_is_reported_with_the_nearest() -> None:
    with pytest.raises(InputError, match="design:golden-section"):
        resolve_candidate("design:golden-sectoin")


def test_the_self_test_judges_designs_that_are_there() -> None:
    names = [design.candidate for design in correct_designs()]
    assert {"reference", "published"} <= set(names), names
    near = {f"near:{name}" for name in NEAR_DESIGNS}
    assert set(names) - {"reference", "published"} <= {*DESIGN_CANDIDATES, *near}, names
