"""The rules for scenarios that a candidate may be judged on, each seen to hold and to be broken."""

import math
from typing import Any

import pytest

from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.contracts.current.scenarios.building import (
    base_speed_scenario,
    steady_scenario,
    vehicle_scenario,
)
from drivegate.contracts.current.scenarios.feasibility import (
    coasts,
    is_driven_without_advance,
    is_fair,
    is_feasible,
    unfair_because,
)
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
from drivegate.drives.running import run_scenario
from drivegate.scenarios.changes import (
    pulsed,
    stepped,
    with_drift,
    with_imbalance,
    with_load_shares,
    with_restarts,
    with_scales,
    with_speed,
    with_supply,
)
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.steady.oracle import feasible_edge, least_current_sum
from drivegate_models.units import RADIANS_PER_RPM

DRIVE = load_drive("paper-5-phase")


def steady(speed_rpm: float, share: float = 1.0, *, power: bool = False) -> Scenario:
    return steady_scenario(DRIVE, speed_rpm, power_share=share, constant_power=power)


def test_every_fixed_scenario_is_fair() -> None:
    unfair = [scenario.name for scenario in fixed_scenarios(DRIVE) if not is_fair(scenario)]
    assert not unfair


def test_fixed_scenarios_differ_and_begin_with_the_lock_up() -> None:
    names = [scenario.name for scenario in fixed_scenarios(DRIVE)]
    assert names[:2] == ["lock-up", "fig5-search"]
    assert len(set(names)) == len(names), sorted(names)


def test_a_speed_range_chooses_among_the_fixed_scenarios_and_always_leaves_one() -> None:
    chosen = fixed_scenarios(DRIVE, (600.0, 1000.0))
    assert {speed for scenario in chosen for _, speed in scenario.speed_rpm} == {600.0, 700.0, 900.0, 1000.0}
    (only,) = fixed_scenarios(DRIVE, (1001.0, 1009.0))
    assert only.speed_rpm == ((0.0, 1005.0),)


@pytest.mark.parametrize(
    ("changed", "feasible"),
    [
        (steady(700.0), True),
        (with_scales(steady(550.0), inductance=1.2), False),
        (with_scales(steady(550.0), emf_constant=0.95), True),
        (with_scales(steady(550.0), emf_constant=0.95, inductance=1.1), False),
        (with_supply(steady(550.0), pulsed(1.0, 0.7, 10.0, 0.1)), False),
        (with_supply(steady(550.0), pulsed(1.0, 0.95, 10.0, 0.1)), True),
        (with_imbalance(steady(550.0), stepped(0.0, -0.3, 5.0)), False),
        (with_drift(steady(550.0), emf_constant=stepped(1.0, 0.9, 2.0, over_s=3.0)), False),
        (with_load_shares(steady(700.0, power=True), (0.0, 0.1), (10.0, 1.5)), False),
        (with_speed(steady(1500.0, power=True), stepped(550.0, 1500.0, 10.0)), False),
        (with_speed(steady(1500.0, 0.5), stepped(900.0, 1500.0, 10.0)), True),
        (base_speed_scenario(DRIVE, 300.0, 520.0, 5.0), True),
    ],
    ids=lambda value: value.name if isinstance(value, Scenario) else None,
)
def test_feasible_means_an_angle_for_every_corner_of_the_profiles(changed: Scenario, feasible: bool) -> None:
    assert is_feasible(changed) is feasible, changed.description


@pytest.mark.parametrize(("share", "fair"), [(1.025, True), (1.04, False)])
def test_constant_power_must_be_within_reach_at_the_speed_that_its_ramp_costs(
    share: float, fair: bool
) -> None:
    """The plant agrees: near its limit the drive holds the speed exactly when the rule holds."""
    scenario = steady(550.0, share, power=True)
    torque = scenario.load.torque_at(550.0)
    assert math.isfinite(feasible_edge(DRIVE.plant(), 550.0 * RADIANS_PER_RPM, torque + 0.1)), (
        "reached at 550 rpm"
    )
    assert is_feasible(scenario) is fair
    run = run_scenario(scenario.replaced(duration_s=2.0), load_controller(resolve_candidate("reference")))
    assert (run.observed.speed_final > 545.0 * RADIANS_PER_RPM) is fair, run.observed.speed_final


def drive_with_little_reserve(slope_deg_per_rpm: float) -> DriveDocument:
    """Make a drive of 350 W whose line of angles leaves a reserve of 3.5 % of the torque at 245 rpm."""
    return load_drive("star-3-phase-150-emf").replaced(
        pole_pairs=16,
        resistance_ohm=0.00203,
        inductance_h=0.000134,
        emf_constant_v_s_per_rad=0.124,
        emf_shape="sine",
        emf_flat_deg=None,
        core_loss_conductance_s=0.00792,
        inertia_kg_m2=0.0879,
        friction_n_m=0.142,
        viscous_friction_n_m_s_per_rad=0.0118,
        supply_voltage_v=7.54,
        hysteresis_band_a=1.53,
        base_speed_rpm=231.0,
        highest_speed_rpm=365.0,
        overspeed_rpm=431.0,
        rated_power_w=350.0,
        current_limit_a=73.1,
        start_deg=7.4,
        slope_deg_per_rpm=slope_deg_per_rpm,
    )


@pytest.mark.parametrize(("power_w", "fair"), [(350.0, False), (345.0, True)])
def test_the_load_at_that_speed_must_be_within_reach_by_the_angle_that_controllers_begin_with(
    power_w: float, fair: bool
) -> None:
    """At 350 W every correct design stalls, at 345 W none does."""
    drive = drive_with_little_reserve(-0.0552)
    run = steady_scenario(drive, 245.0, power_share=power_w / 350.0, constant_power=True)
    assert (unfair_because(run) is None) is fair
    made = run_scenario(run.replaced(duration_s=2.0), load_controller(resolve_candidate("reference")))
    assert (made.observed.speed_final > 240.0 * RADIANS_PER_RPM) is fair, made.observed.speed_final


def drive_whose_line_is_too_steep() -> DriveDocument:
    """Make a drive of 337 W on which no straight line of angles gives rated power at all speeds."""
    return load_drive("star-3-phase").replaced(
        pole_pairs=3,
        resistance_ohm=0.138,
        inductance_h=0.00111,
        emf_constant_v_s_per_rad=0.0735,
        emf_shape="trapezoid",
        emf_flat_deg=73.1,
        core_loss_conductance_s=0.00841,
        inertia_kg_m2=0.00402,
        friction_n_m=0.0279,
        viscous_friction_n_m_s_per_rad=0.000345,
        supply_voltage_v=15.1,
        hysteresis_band_a=0.729,
        base_speed_rpm=1060.0,
        highest_speed_rpm=2470.0,
        overspeed_rpm=2740.0,
        rated_power_w=337.0,
        current_limit_a=26.9,
        start_deg=43.4,
        slope_deg_per_rpm=0.02525,
    )


@pytest.mark.parametrize(
    ("speed", "torque_nm", "constant_power", "fair"),
    [
        (1130.0, 2.848, True, False),
        (1500.0, 2.145, True, True),
        (2470.0, 1.337, False, False),
        (2000.0, 1.337, False, True),
    ],
)
def test_the_angle_that_controllers_begin_with_may_not_lie_beyond_those_that_give_the_load(
    speed: float, torque_nm: float, constant_power: bool, fair: bool
) -> None:
    """Every design stalls at 1130 rpm, and rests with 16 % more current at 2470 rpm."""
    drive = drive_whose_line_is_too_steep()
    share = torque_nm * speed * RADIANS_PER_RPM / 337.0
    run = steady_scenario(drive, speed, power_share=share, constant_power=constant_power)
    assert (unfair_because(run) is None) is fair
    made = run_scenario(run, load_controller(resolve_candidate("reference")))
    needed = (
        1.02 * least_current_sum(drive.plant(), speed * RADIANS_PER_RPM, made.windows[-1].torque).current_sum
    )
    holds = made.observed.speed_final > 0.99 * speed * RADIANS_PER_RPM
    assert (holds and made.windows[-1].current_sum < needed) is fair, made.windows[-1]


@pytest.mark.parametrize(("speed", "fair"), [(2080.0, False), (2200.0, True)])
def test_constant_power_may_not_pull_the_shaft_below_base_speed_while_it_comes_on(
    speed: float, fair: bool
) -> None:
    """Below base speed there is no advance, without which this drive loses the load."""
    drive = load_drive("star-3-phase").replaced(
        pole_pairs=3,
        resistance_ohm=0.145,
        inductance_h=0.00151,
        emf_constant_v_s_per_rad=0.0366,
        emf_shape="trapezoid",
        emf_flat_deg=67.2,
        core_loss_conductance_s=0.000194,
        inertia_kg_m2=0.000327,
        friction_n_m=0.0012,
        viscous_friction_n_m_s_per_rad=1.51e-5,
        supply_voltage_v=21.3,
        hysteresis_band_a=0.543,
        base_speed_rpm=2020.0,
        highest_speed_rpm=3110.0,
        overspeed_rpm=4040.0,
        rated_power_w=282.0,
        current_limit_a=21.3,
        start_deg=25.1,
        slope_deg_per_rpm=0.0027,
    )
    run = steady_scenario(drive, speed, power_share=1.0, constant_power=True)
    assert (unfair_because(run) is None) is fair
    made = run_scenario(run.replaced(duration_s=2.0), load_controller(resolve_candidate("reference")))
    assert (made.observed.speed_final > 0.99 * speed * RADIANS_PER_RPM) is fair, made.observed.speed_final


def test_a_line_that_falls_below_zero_ends_there() -> None:
    drive = drive_with_little_reserve(-0.08)
    assert is_fair(steady_scenario(drive, 365.0, power_share=1.0, constant_power=True))


@pytest.mark.parametrize(("grade", "fair"), [(0.0, True), (3.0, True), (-3.0, False), (30.0, False)])
def test_a_vehicle_can_neither_be_braked_nor_climb_any_hill(grade: float, fair: bool) -> None:
    road = stepped(0.0, grade, 5.0)
    assert is_fair(vehicle_scenario(DRIVE, 1000.0, mass_units=4, gear_units=4, grade_percent=road)) is fair


def test_friction_counts_as_load() -> None:
    """At 1500 rpm, between the greatest torque with and without 0.5 N m of friction."""
    speed, torque = 1500.0 * RADIANS_PER_RPM, 9.0
    while math.isfinite(feasible_edge(DRIVE.plant(), speed, torque + 0.4)):
        torque += 0.1
    scenario = steady(1500.0)
    near = scenario.replaced(load=scenario.load.model_copy(update={"torque_nm": torque}))
    assert is_feasible(near)
    assert not is_feasible(with_scales(near, friction_added_n_m=0.5))


@pytest.mark.parametrize(("over_s", "slow_enough"), [(0.0, False), (0.2, False), (0.6, True), (3.0, True)])
def test_a_reference_may_not_fall_faster_than_the_shaft_coasts(
    altered: Any, over_s: float, slow_enough: bool
) -> None:
    """The plant agrees: without current its speed falls below the reference exactly when the rule holds."""
    scenario = with_speed(steady(1500.0, 0.5), stepped(1400.0, 900.0, 1.0, over_s=over_s))
    assert coasts(scenario) is slow_enough

    def idle_from_the_ramp(sense: Any, command: Any) -> None:
        if sense["time"] >= 1.0:
            command["current_reference"] = 0.0

    ended = scenario.replaced(duration_s=round(1.0 + max(over_s, 0.1), 1))
    run = run_scenario(ended, altered("initial", idle_from_the_ramp))
    below = run.observed.speed_final < 900.0 * RADIANS_PER_RPM
    assert below is slow_enough, f"the shaft ends at {run.observed.speed_final} rad/s"


@pytest.mark.parametrize(("fall", "slow_enough"), [(10.0, True), (14.0, False)])
def test_an_unloaded_shaft_is_slowed_by_its_core_loss_alone(fall: float, slow_enough: bool) -> None:
    scenario = base_speed_scenario(DRIVE, 480.0, 520.0, fall)
    assert coasts(scenario) is slow_enough


@pytest.mark.parametrize(("torque", "fair"), [(2.0, True), (15.0, True), (20.0, False)])
def test_a_load_below_base_speed_is_what_no_advance_is_needed_for(torque: float, fair: bool) -> None:
    """At 500 rpm, 26 A and an angle of zero give 19 N·m; at 480 rpm a little more."""
    slow = with_speed(steady(600.0), stepped(300.0, 600.0, 5.0, over_s=10.0))
    slow = slow.replaced(load=slow.load.model_copy(update={"torque_nm": torque}))
    assert is_driven_without_advance(slow) is fair
    assert is_fair(slow) is fair, unfair_because(slow)
    assert is_driven_without_advance(base_speed_scenario(DRIVE, 300.0, 520.0, 5.0))


def test_a_reference_through_base_speed_needs_its_acceleration_without_advance() -> None:
    slow = steady(600.0).replaced(load=steady(600.0).load.model_copy(update={"torque_nm": 15.0}))
    assert is_driven_without_advance(with_speed(slow, stepped(0.0, 600.0, 5.0, over_s=2.0)))
    assert not is_driven_without_advance(with_speed(slow, stepped(0.0, 600.0, 5.0, over_s=0.5)))


@pytest.mark.parametrize(("speed", "fair"), [(570.0, False), (600.0, True), (1500.0, True)])
def test_to_a_controller_that_is_restarted_the_whole_load_comes_at_once(speed: float, fair: bool) -> None:
    """Its current stops for 20 ms: at 570 rpm and 25.1 N·m the shaft falls by 96 rpm, at 600 rpm by 91."""
    scenario = with_restarts(steady(speed, power=True), 5.0)
    assert (unfair_because(scenario) is None) is fair, unfair_because(scenario)
    assert is_fair(steady(speed, power=True))


def test_a_run_that_does_not_start_at_its_reference_is_not_fair() -> None:
    assert not is_fair(steady(1500.0).replaced(initial_speed_rpm=1400.0))


@pytest.mark.parametrize(
    ("scenario", "reason"),
    [
        (steady(1500.0), None),
        (steady(1500.0).replaced(initial_speed_rpm=1400.0), "does not start at its speed reference"),
        (with_speed(steady(550.0, 0.9), stepped(480.0, 550.0, 5.0)), "a load below base speed"),
        (with_restarts(steady(560.0), 5.0), "a restart"),
        (with_speed(steady(1500.0, 0.5), stepped(1400.0, 900.0, 1.0)), "falls faster than the shaft coasts"),
        (with_scales(steady(550.0), inductance=1.2), "no advance angle gives the torque"),
    ],
)
def test_the_reason_why_a_scenario_is_infeasible_is_reported(scenario: Scenario, reason: str | None) -> None:
    given = unfair_because(scenario)
    assert (given is None) if reason is None else (reason in str(given)), given


def test_an_operating_point_is_searched_for_once(monkeypatch: pytest.MonkeyPatch) -> None:
    from drivegate.contracts.current.scenarios import feasibility

    calls: list[float] = []

    def counted(*point: Any) -> float:
        calls.append(point[1])
        return feasible_edge(*point)

    monkeypatch.setattr(feasibility, "feasible_edge", counted)
    scenario = with_scales(steady(1490.0), resistance=1.07)
    assert is_feasible(scenario)
    assert is_feasible(with_load_shares(scenario, (0.0, 1.0), (10.0, 1.0)))
    assert len(calls) == 1, f"{len(calls)} searches for one operating point"
