"""Scenarios of PM AC drives: fair, named, whole control periods, and exercising what their families are there for."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from itertools import pairwise

import pytest
from hypothesis import HealthCheck, Phase, find, given, seed, settings

from drivegate.contracts.catalogue import contract_named
from drivegate.contracts.duty.scenarios.building import (
    failing,
    load_step_scenario,
    speed_scenario,
    torque_of,
    torque_scenario,
)
from drivegate.contracts.duty.scenarios.drawn.failures import failure_scenarios
from drivegate.contracts.duty.scenarios.drawn.families import (
    FAMILY_GROUPS,
    SENSORLESS_GROUPS,
    drawn_scenarios,
)
from drivegate.contracts.duty.scenarios.drawn.hot import hot_winding_scenarios
from drivegate.contracts.duty.scenarios.drawn.linked import link_scenarios
from drivegate.contracts.duty.scenarios.feasibility import unfair_because
from drivegate.contracts.duty.scenarios.fixed import fixed_scenarios
from drivegate.contracts.duty.scenarios.simplification import DUTY_SIMPLIFICATIONS
from drivegate.contracts.duty.scenarios.windows import duty_windows
from drivegate.contracts.traceability import SPECIAL, family_name, traced_checks
from drivegate.scenarios.changes import with_scales
from drivegate.scenarios.facts import facts_of
from drivegate.scenarios.simplification import simplified
from drivegate_cases.drive.drive_document import drive_names, load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.failure_kind import FAILURE_KINDS
from drivegate_cases.scenario.reference import Reference, reference_of
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import ShuntSensors
from drivegate_models.pm_ac.oracle import greatest_torque, undistorted_limits
from drivegate_models.units import RADIANS_PER_RPM

DRIVES = [drive for name in drive_names() if isinstance(drive := load_drive(name), PmAcDocument)]
INTERIOR = next(drive for drive in DRIVES if drive.name == "pm-ac-interior")
BASE = INTERIOR.rating.base_speed_rpm
HEATED = INTERIOR.replaced(
    thermal={
        "heat_capacity_j_per_k": 3.4,
        "thermal_resistance_k_per_w": 4.3,
        "limit_c": 130.0,
        "sensor_lag_s": 0.5,
    }
)
FAMILIES = list(dict.fromkeys(family for group in FAMILY_GROUPS for family in group))
SPECIAL_DRIVES = {
    hot_winding_scenarios: HEATED,
    link_scenarios: next(drive for drive in DRIVES if drive.name == "pm-ac-chopper"),
}
# What is true of every draw is looked at in the first one, which need not become simple.
FIRST = settings(max_examples=10, phases=[Phase.generate], database=None, derandomize=True)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("drive", DRIVES, ids=lambda drive: drive.name)
def test_the_fixed_scenarios_are_fair_judged_somewhere_and_reported_apart(drive: PmAcDocument) -> None:
    fixed = fixed_scenarios(drive, detected=FAILURE_KINDS)
    assert [scenario.name for scenario in fixed if (reason := unfair_because(scenario)) is not None] == [], (
        reason
    )
    assert [scenario.name for scenario in fixed if not duty_windows(scenario)] == []
    counts = Counter(scenario.name for scenario in fixed)
    assert [name for name, count in counts.items() if count > 1] == [], "one name for different runs"
    stuck = [run for run in fixed if run.failure is not None and run.failure.kind == "locked-rotor"]
    assert [run.initial_speed_rpm for run in stuck] == [drive.rating.base_speed_rpm, 0.0]


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family_name(family.__name__))
def test_what_a_family_draws_is_judged_somewhere(family: object) -> None:
    drawn: list[Scenario] = []

    @seed(0)
    @settings(
        max_examples=10,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(family(SPECIAL_DRIVES.get(family, INTERIOR)))  # type: ignore[operator]
    def draw(scenario: Scenario) -> None:
        drawn.append(scenario)

    draw()
    assert all(duty_windows(scenario) for scenario in drawn)
    assert any(unfair_because(scenario) is None for scenario in drawn)


def test_every_family_and_every_check_has_its_row() -> None:
    every = (*FAMILIES, *(family for group in SENSORLESS_GROUPS for family in group))
    assert {family_name(family.__name__) for family in every} == set(contract_named("duty").families)
    known = {check.id for check in contract_named("duty").checks}
    assert all(row["families"] for row in traced_checks(INTERIOR))
    assert {row["id"] for row in traced_checks(INTERIOR)} == known
    assert {*SPECIAL["repetition"], *SPECIAL["timing"]} <= known


def test_a_load_out_of_reach_is_unfair_and_a_torque_reference_out_of_reach_is_not() -> None:
    top = INTERIOR.rating.highest_speed_rpm
    much = torque_of(INTERIOR, top, 2.0)
    assert unfair_because(load_step_scenario(INTERIOR, top, much, (0.0, 1.0))) is not None
    assert unfair_because(torque_scenario(INTERIOR, top, (0.0, much))) is None


@pytest.mark.parametrize(
    ("speed_share", "torque_share", "is_fair"),
    [(0.01, 0.02, True), (0.01, 0.1, False), (0.09, 0.18, True), (0.09, 0.2, False), (0.1, 0.8, True)],
)
def test_a_load_that_stops_a_slow_shaft_is_set_aside(
    speed_share: float, torque_share: float, is_fair: bool
) -> None:
    speed = speed_share * BASE
    run = speed_scenario(INTERIOR, (speed,), torque_nm=torque_of(INTERIOR, speed, torque_share))
    reason = unfair_because(run.replaced(initial_speed_rpm=0.0))
    assert (reason is None) is is_fair, reason


def test_a_shaft_that_is_to_stand_is_not_judged_for_being_locked() -> None:
    start = speed_scenario(INTERIOR, (BASE,), torque_nm=0.5, initial_speed_rpm=0.0)
    assert unfair_because(failing(start, "locked-rotor", 0.0)) is None, (
        "a start shows that the shaft is locked"
    )
    resting = failing(start.replaced(speed_rpm=((0.0, 0.0),)), "locked-rotor", 0.0)
    assert "below 20 % of base speed" in str(unfair_because(resting))
    stopping = failing(start.replaced(speed_rpm=((0.0, 0.0),), initial_speed_rpm=BASE), "locked-rotor", 0.0)
    assert unfair_because(stopping) is None, "a sudden stop shows it"


@pytest.mark.parametrize(
    ("speed_share", "torque_share", "reason"),
    [
        (0.2, 0.3, None),
        (1.0, 0.6, None),
        (0.0, 0.5, "below 20 % of base speed"),
        (0.15, 0.5, "below 20 % of base speed"),
        (1.1, 0.5, "above base speed"),
        (0.5, 0.25, "below 30 % of rated torque"),
        (0.5, 0.0, "below 30 % of rated torque"),
    ],
)
@pytest.mark.parametrize("reference", ["speed", "torque"])
def test_nobody_is_judged_on_a_failure_that_may_not_show(
    speed_share: float, torque_share: float, reason: str | None, reference: Reference
) -> None:
    speed = speed_share * BASE
    torque = torque_of(INTERIOR, speed, torque_share)
    held = torque_scenario(INTERIOR, speed, (torque,))
    run = held if reference == "torque" else speed_scenario(INTERIOR, (speed,), torque_nm=torque)
    found = unfair_because(failing(run, "open-phase", 0.5 * run.duration_s))
    assert found is None if reason is None else reason in str(found)


def test_a_start_whose_diodes_drive_too_much_current_is_set_aside() -> None:
    top = INTERIOR.rating.highest_speed_rpm
    start = torque_scenario(INTERIOR, top, (0.0,))
    assert unfair_because(start) is None, "the diodes conduct, but within the limit"
    weak = start.replaced(drive=INTERIOR.replaced(peak_current_percent=100.0, current_limit_a=2.0))
    reason = "it begins so fast that the current through the diodes alone exceeds the limit of OVC-1"
    assert unfair_because(weak) == reason
    free = speed_scenario(weak.drive, (top,), initial_speed_rpm=top)  # type: ignore[arg-type]
    assert unfair_because(free) == reason
    ramped = speed_scenario(weak.drive, (top,), initial_speed_rpm=0.0)  # type: ignore[arg-type]
    assert unfair_because(ramped) != reason


def test_a_load_that_only_the_whole_voltage_can_drive_is_unfair() -> None:
    """Between both limits of a drive whose torque falls steeply with the voltage."""
    msl = next(drive for drive in DRIVES if drive.name == "pm-ac-msl")
    top = msl.rating.highest_speed_rpm
    plant = msl.plant()
    greatest = greatest_torque(plant, undistorted_limits(plant), top * RADIANS_PER_RPM).torque
    run = speed_scenario(msl, (top,), torque_nm=round(0.9 * greatest, 3))
    assert unfair_because(run) is not None
    strict = msl.replaced(weakening_voltage_percent=100.0)
    assert unfair_because(run.replaced(drive=strict)) is None


def test_an_unknown_plant_is_not_taken_over_at_full_speed() -> None:
    top = INTERIOR.rating.highest_speed_rpm
    run = torque_scenario(INTERIOR, top, (0.0,))
    assert unfair_because(run) is None
    assert "begins above base speed" in str(unfair_because(with_scales(run, inductance=0.7)))


def test_a_scenario_can_be_made_simpler_down_to_one_torque() -> None:
    scenario = torque_scenario(INTERIOR, 1234.0, (0.0, 1.237, 0.4, 0.0))
    simpler = [
        found
        for simplification in DUTY_SIMPLIFICATIONS
        for fields in simplification(scenario)
        if (found := simplified(scenario, fields)) is not None
    ]
    lengths = {len(found.torque_reference_profile) for found in simpler}
    assert 1 in lengths, "a single torque is among the simpler runs"
    assert any(found.speed_rpm == ((0.0, 0.0),) for found in simpler), "so is a standstill"
    assert all(duty_windows(found) for found in simpler)


def position(run: Scenario) -> str:
    """Return what gives the position in a run with shunts."""
    assert isinstance(run.sensors, ShuntSensors)
    assert run.sensors.position is not None
    return run.sensors.position


def test_edges_of_both_kinds_are_lost_under_a_torque_and_stay_of_their_kind() -> None:
    fixed = [run for run in fixed_scenarios(INTERIOR, detected=("lost-edge",)) if run.failure is not None]
    assert {position(run) for run in fixed} == {"encoder", "hall"}
    by_hall = next(run for run in fixed if position(run) == "hall")
    assert "shunts-hall-lost-edge" in by_hall.name
    assert "shunts sensors with Hall switches of seed 1" in facts_of(by_hall.to_mapping())
    odd = by_hall.replaced(sensors=by_hall.sensors.model_copy(update={"placement_error_deg": 3.0}), seed=7)
    simpler = [
        found
        for simplification in DUTY_SIMPLIFICATIONS
        for fields in simplification(odd)
        if (found := simplified(odd, fields)) is not None
    ]
    assert any(found.sensors == by_hall.sensors for found in simpler)
    assert {position(found) for found in simpler} == {"hall"}
    assert not [
        run for run in fixed_scenarios(INTERIOR, ("speed",), ("lost-edge",)) if run.failure is not None
    ]


def test_a_fan_a_load_that_vanishes_and_a_wait_are_always_run() -> None:
    fixed = fixed_scenarios(INTERIOR)
    assert any(run.load.kind == "fan" for run in fixed)
    shares = [[share for _, share in run.load_profile] for run in fixed]
    assert any(0.0 in own[1:-1] and own[0] == own[-1] == 1.0 for own in shares)
    waits = [
        end - start
        for run in fixed
        for (start, first), (end, last) in pairwise(run.speed_rpm)
        if first == last == 0.0
    ]
    assert max(waits) > 1.0


def test_only_failures_that_a_candidate_detects_are_given() -> None:
    def kinds(runs: Iterable[Scenario]) -> set[str]:
        return {run.failure.kind for run in runs if run.failure is not None}

    assert kinds(fixed_scenarios(INTERIOR)) == set()
    assert kinds(fixed_scenarios(INTERIOR, detected=FAILURE_KINDS)) == set(FAILURE_KINDS)
    assert kinds(fixed_scenarios(INTERIOR, ("torque",), FAILURE_KINDS)) == set(FAILURE_KINDS) - {
        "locked-rotor"
    }
    assert kinds(fixed_scenarios(INTERIOR, detected=("stuck-current",))) == {"stuck-current"}
    group = next(place for place, group in enumerate(FAMILY_GROUPS) if failure_scenarios in group)
    given_one = drawn_scenarios(INTERIOR, group, detected=("stuck-current",))
    found = find(given_one, lambda run: run.failure is not None, settings=settings(FIRST, max_examples=200))
    assert kinds([found]) == {"stuck-current"}
    without = [
        find(drawn_scenarios(INTERIOR, group, ("torque",), detected), lambda _: True, settings=FIRST)
        for detected in ((), ("locked-rotor",))
    ]
    assert kinds(without) == set(), "a held shaft does not lock up"


@pytest.mark.parametrize("reference", ["speed", "torque"])
def test_only_references_that_a_candidate_follows_are_given(reference: Reference) -> None:
    fixed = fixed_scenarios(INTERIOR, (reference,))
    assert {reference_of(scenario) for scenario in fixed} == {reference}
    assert set(fixed) < set(fixed_scenarios(INTERIOR))
    for group in range(8):
        drawn = find(drawn_scenarios(INTERIOR, group, (reference,)), lambda _: True, settings=FIRST)
        assert reference_of(drawn) == reference, f"group {group} draws another reference"
