"""Scenarios in shares of their drive: the paper's numbers on the paper's drive, and others on another one."""

import hashlib
import json

import pytest
from hypothesis import HealthCheck, given, settings

from drivegate.contracts.current.scenarios.combined import combined_scenarios
from drivegate.contracts.current.scenarios.drawn.families import FAMILY_GROUPS, Family
from drivegate.contracts.current.scenarios.feasibility import coasted_rate, unfair_because
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
from drivegate.contracts.current.scenarios.rare import rare_scenarios
from drivegate.scenarios.drive_scale import DriveScale, scale_of, scale_of_mapping
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario

PAPER = load_drive("paper-5-phase")
SMALL = PAPER.replaced(
    name="small",
    phases=3,
    pole_pairs=4,
    resistance_ohm=0.074,
    inductance_h=1.2e-3,
    emf_constant_v_s_per_rad=0.0141,
    inertia_kg_m2=2e-5,
    supply_voltage_v=12.0,
    hysteresis_band_a=0.07,
    base_speed_rpm=3000.0,
    highest_speed_rpm=8000.0,
    overspeed_rpm=10000.0,
    rated_power_w=60.0,
    current_limit_a=7.5,
    requirements={},
)
SLOW = PAPER.replaced(name="slow", inertia_kg_m2=0.1, requirements={})


def test_the_drive_of_the_paper_has_the_numbers_of_the_paper() -> None:
    assert scale_of(PAPER) == DriveScale(
        base_speed_rpm=500.0,
        lowest_loaded_rpm=550.0,
        highest_loaded_rpm=1500.0,
        overspeed_rpm=2000.0,
        speed_grain_rpm=5.0,
        speed_step_rpm=10.0,
        rated_torque_nm=pytest.approx(28.648, abs=1e-3),  # type: ignore[arg-type]
        torque_step_nm=0.1,
        standstill_torque_nm=12.0,
        offset_step_a=0.02,
        supply_step_v=0.1,
        current_sum_a=40.0,
        mass_unit_kg=50.0,
        gear_unit=1.0,
        drag_area_m2=0.6,
        time_unit_s=1.0,
        load_ramp_s=0.2,
        load_ramp_cost_rpm=pytest.approx(22.8, abs=0.1),  # type: ignore[arg-type]
        settling_s=6.0,
        shortest_window_s=3.0,
        dropout_step_s=0.001,
    )


def digest(scenarios: tuple[Scenario, ...]) -> str:
    """Name scenarios by all of their numbers, without the drive itself."""
    content = [scenario.to_mapping() for scenario in scenarios]
    for mapping in content:
        del mapping["drive"]
        assert mapping["scales"].pop("inertia") == 1.0, "a key that is younger than these names"
        assert mapping.pop("turns_before") == 0, "and another one"
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def test_the_drive_of_the_paper_is_run_as_it_was_before_drives_had_scales() -> None:
    """A change of these numbers changes every verdict that was given before."""
    younger = (
        "1650-1900rpm-1500W",
        "600rpm-11.94Nm-100-0-100%",
        "800-1100rpm-9.115Nm-100-0-100%-J-changes×1-0.3-1",
    )
    rare = rare_scenarios(PAPER)
    fixed = tuple(run for run in fixed_scenarios(PAPER) if run.name not in younger and run not in rare)
    assert digest(fixed) == "34967f933f9143e1", "the fixed scenarios"
    # The long run under a changing load has moved to lower speeds since.
    assert digest(combined_scenarios(PAPER, None, 0)) == "b3ce29fc5f36fa18", "the joint scenarios of seed 0"


def test_a_small_drive_is_run_at_its_own_speeds_and_loads() -> None:
    fixed = {scenario.name: scenario for scenario in fixed_scenarios(SMALL)}
    assert len(fixed) == 39 + len(rare_scenarios(SMALL)), sorted(fixed)
    speeds = {speed for scenario in fixed.values() for _, speed in scenario.speed_rpm}
    assert min(speeds - {0.0}) == 2200.0, "0.73 of base speed, where an unloaded run begins"
    assert max(speeds) == 10000.0, "overspeed"
    assert fixed["lock-up"].load.torque_nm == 0.0735, "2.6 % above 60 W at 8000 rpm"  # type: ignore[union-attr]
    assert fixed["lock-up"].description.startswith("8000 rpm and 0.0735 N·m: Fig. 4")
    assert "8000rpm-0.0573Nm-friction+0.0025Nm" in fixed, sorted(fixed)


def test_a_drive_of_twice_the_inertia_has_twice_the_time() -> None:
    scale = scale_of(SLOW)
    assert (scale.settling_s, scale.dwell_s, scale.load_ramp_s, scale.long_s) == (12.0, 20.0, 0.4, 300.0)
    times = {scenario.name: scenario.duration_s for scenario in fixed_scenarios(SLOW)}
    assert times["700rpm-1500W"] == 20.4
    assert times["1400-900rpm-6.139Nm"] == 44.0, "a ramp of 4 s after 20 s, and 20 s to converge again"


def test_a_stated_settling_time_makes_every_stretch_as_long() -> None:
    scale = scale_of(PAPER.replaced(settling_s=9.0))
    assert (scale.dwell_s, scale.change_s, scale.change_step_s) == (13.0, 13.0, 0.65)


def test_a_drive_as_plain_data_has_the_same_scale() -> None:
    assert scale_of_mapping(SMALL.to_mapping()) == scale_of(SMALL)


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    "family", [family for group in FAMILY_GROUPS for family in group], ids=lambda family: family.__name__
)
@pytest.mark.parametrize("drive", [SMALL, SLOW], ids=lambda drive: drive.name)
def test_every_family_draws_within_the_range_of_another_drive(drive, family: Family) -> None:
    @settings(max_examples=25, database=None, suppress_health_check=list(HealthCheck))
    @given(scenario=family(drive, None))
    def holds(scenario: Scenario) -> None:
        speeds = [speed for _, speed in scenario.speed_rpm]
        assert max(speeds) <= drive.rating.overspeed_rpm, scenario.name
        assert max(speeds) > drive.rating.base_speed_rpm, scenario.name

    holds()


def test_an_unloaded_reference_falls_no_faster_than_the_shaft_coasts() -> None:
    braked = SMALL.replaced(core_loss_conductance_s=3e-3)
    slowly = braked.replaced(inertia_kg_m2=3e-4)
    free = SMALL.replaced(core_loss_conductance_s=0.0)
    assert coasted_rate(braked, 20.0) == 20.0
    assert 11.0 < coasted_rate(slowly, 20.0) < 12.0, "what drag and inertia make of it"
    assert coasted_rate(free, 20.0) == 0.0, "nothing slows it down"
    for drive in (braked, slowly, free):
        unfair = {run.name: why for run in fixed_scenarios(drive) if (why := unfair_because(run))}
        assert not [name for name in unfair if "unloaded" in name], unfair
    rising = next(run for run in fixed_scenarios(free) if run.name.endswith("unloaded"))
    assert [speed for _, speed in rising.speed_rpm] == [2200.0, 2200.0, 3080.0]


def test_joint_runs_are_drawn_for_another_drive() -> None:
    drawn = combined_scenarios(SMALL, None, 0)
    assert len(drawn) >= 50, f"only {len(drawn)} rows have a fair run"
    assert all(scenario.drive == SMALL for scenario in drawn)


@pytest.mark.nightly
def test_a_star_is_run_through_hall_switches_which_see_no_false_edges() -> None:
    star = load_drive("star-3-phase")
    drawn = (*fixed_scenarios(star), *combined_scenarios(star, None, 0))
    assert {scenario.sensors.kind for scenario in drawn} == {"ideal", "hall"}
    assert not any(scenario.glitches for scenario in drawn)
    paper = (*fixed_scenarios(PAPER), *combined_scenarios(PAPER, None, 0))
    assert {scenario.sensors.kind for scenario in paper} == {"ideal", "mcs96"}
    assert any(scenario.glitches for scenario in paper)
