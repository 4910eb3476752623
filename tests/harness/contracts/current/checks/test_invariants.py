"""The four laws that drivegate is known for, each as a property, and each seen to fail when it is broken."""

import math

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from drivegate.candidates.builtin.loading import BuiltinController
from drivegate.candidates.controller import Controller
from drivegate.candidates.declaration import Declaration
from drivegate.contracts.current.checks.command_range import angle_below_base
from drivegate.contracts.current.checks.convergence import converges
from drivegate.contracts.current.checks.power import estimated_power, exchanged_power
from drivegate.contracts.current.checks.ripple import ripple_at_converged_angle
from drivegate.contracts.current.record import CurrentRecord
from drivegate.contracts.current.scenarios.drawn.families import (
    base_speed_scenarios,
    drawn_scenarios,
    steady_scenarios,
)
from drivegate.drives.running import run_scenario
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.scenario.scenario import Scenario, load_scenario
from drivegate_models.controllers.current.builtin import SEARCHES
from drivegate_models.machine.period import PERIODIC
from drivegate_models.steady.oracle import feasible_edge, point_at_torque
from drivegate_models.steady.steady_state import steady_state
from drivegate_models.units import RADIANS_PER_RPM

DRIVE = load_drive("paper-5-phase")
PLANT = DRIVE.plant()
FEW = settings(max_examples=12, database=None, derandomize=True, suppress_health_check=list(HealthCheck))
MANY = settings(FEW, max_examples=150)
RIPPLE_SPEED = 1500.0 * RADIANS_PER_RPM


def record(scenario: Scenario, controller: Controller | None = None) -> CurrentRecord:
    run = run_scenario(scenario, controller or BuiltinController(SEARCHES["reference"]))
    return CurrentRecord(scenario, run, Declaration(estimates_power=True))


@MANY
@given(
    speed=st.integers(1, 300), advance=st.integers(0, 90), reference=st.integers(1, 104), ideal=st.booleans()
)
def test_input_power_equals_half_supply_voltage_times_current_sum(
    speed: int, advance: int, reference: int, ideal: bool
) -> None:
    """P4: exact for the power exchanged; for the net winding power only while no phase returns current."""
    drive = PLANT._replace(hysteresis_band=0.0 if ideal else PLANT.hysteresis_band)
    state = steady_state(drive, float(speed), 0.25 * reference, math.radians(advance))
    product = drive.half_supply_voltage * state.current_sum
    assert state.exchanged_power == pytest.approx(product, rel=1e-9), (
        f"exchanged {state.exchanged_power} W, but V·Σ|i| is {product} W"
    )
    net = product - 2.0 * state.returned_power
    assert state.source_power == pytest.approx(net, rel=1e-9, abs=1e-9 * product), (
        f"net input {state.source_power} W, but V·Σ|i| less twice the returned power is {net} W"
    )
    assert (state.source_power < product * (1.0 - 1e-9)) == (state.returned_power > 0.5e-9 * product)
    if state.certified == PERIODIC:
        spent = state.copper_loss + state.torque * speed
        assert state.source_power == pytest.approx(spent, rel=1e-8, abs=1e-7), (
            f"the source gives {state.source_power} W, but copper and shaft take {spent} W"
        )


@FEW
@given(scenario=drawn_scenarios(DRIVE))
def test_input_power_balance_and_estimate_hold_in_closed_loop(scenario: Scenario) -> None:
    run = record(scenario)
    exchanged, estimated = exchanged_power(run), estimated_power(run)
    assert exchanged.met, f"PWR-1 is off by {exchanged.measured} in {scenario.name}"
    assert estimated is not None
    assert estimated.met, f"PWR-2 is off by {estimated.measured} in {scenario.name}"


def test_a_power_estimate_that_is_wrong_by_one_percent_breaks_the_law(altered) -> None:
    def wrong(_sense, command) -> None:
        command["input_power"] *= 1.01

    margin = estimated_power(record(load_scenario("fig5-search"), altered("reference", wrong)))
    assert margin is not None
    assert not margin.met, f"an estimate 1 % too large passes with {margin.measured}"


@FEW
@given(scenario=base_speed_scenarios(DRIVE))
def test_advance_angle_is_zero_below_500_rpm(scenario: Scenario) -> None:
    margin = angle_below_base(record(scenario))
    assert margin is not None, f"{scenario.name} never came below base speed"
    assert margin.met, f"ADV-1: {margin.measured} in {scenario.name}"


@FEW
@given(scenario=base_speed_scenarios(DRIVE), angle=st.floats(1e-12, 0.1))
def test_any_angle_below_500_rpm_breaks_the_law(altered, scenario: Scenario, angle: float) -> None:
    def advanced(_sense, command) -> None:
        command["advance_angle"] = max(float(command["advance_angle"]), angle)

    margin = angle_below_base(record(scenario, altered("reference", advanced)))
    assert margin is not None
    assert not margin.met, f"{angle} rad below base speed passes"


@settings(MANY, max_examples=60)
@given(share=st.floats(0.0, 1.0), resistance=st.floats(0.8, 1.25))
def test_torque_ripple_is_below_13_percent_at_1500_rpm(share: float, resistance: float) -> None:
    """P8: at every angle from the necessary one to the published initial one, ideal regulator."""
    drive = PLANT._replace(hysteresis_band=0.0, resistance=PLANT.resistance * resistance)
    edge = feasible_edge(drive, RIPPLE_SPEED, 9.8)
    angle = edge + share * (math.radians(58.0) - edge)
    point = point_at_torque(drive, RIPPLE_SPEED, angle, 9.8)
    ripple = (point.torque_highest - point.torque_lowest) / point.torque
    assert ripple < limits_of(DRIVE).ripple == 0.13, (
        f"the ripple is {100 * ripple:.2f} % at {math.degrees(angle):.2f}°"
    )


@FEW
@given(milliseconds=st.integers(10, 400))
def test_torque_ripple_is_below_13_percent_where_the_reference_converges(milliseconds: int) -> None:
    scenario = load_scenario("fig5-search")
    load = scenario.load.model_copy(update={"factor": ((0.0, 0.0), (milliseconds / 1000.0, 1.0))})
    margin = ripple_at_converged_angle(record(scenario.model_copy(update={"load": load})))
    assert margin is not None
    assert margin.met, f"RIP-1: {margin.measured}"


def test_a_machine_of_less_inductance_breaks_the_ripple_law() -> None:
    weaker = DRIVE.with_overrides(["inductance_h=0.002"])
    margin = ripple_at_converged_angle(record(load_scenario("fig5-search").replaced(drive=weaker)))
    assert margin is not None
    assert not margin.met, f"2 mH instead of 2.88 mH passes with {margin.measured}"


@FEW
@given(scenario=steady_scenarios(DRIVE))
def test_the_search_converges_within_k1_and_k2(scenario: Scenario) -> None:
    margin = converges(record(scenario))
    assert margin is not None
    assert margin.met, f"CNV-1: {margin.measured} in {scenario.name}"


@pytest.mark.nightly
@FEW
@given(scenario=steady_scenarios(DRIVE))
def test_a_search_that_hunts_for_ever_breaks_the_law(altered, scenario: Scenario) -> None:
    def hunting(sense, command) -> None:
        command["advance_angle"] += math.radians(0.75) * (1.0 + math.sin(3.0 * float(sense["time"])))

    margin = converges(record(scenario, altered("initial", hunting)))
    assert margin is not None
    assert not margin.met, f"a swing of 1.5° passes with {margin.measured}"


def test_the_published_search_breaks_the_law_by_locking_up() -> None:
    scenario = load_scenario("lock-up")
    run = record(scenario, BuiltinController(SEARCHES["published"]))
    margin = converges(run)
    assert margin is not None
    assert not margin.met, f"the literal flowchart converges: {margin.measured}"
    window = next(run.windows()).values
    assert window.reference == pytest.approx(DRIVE.rating.current_limit_a), (
        "it does not stay at the current limit"
    )
