"""What is drawn is valid, fair to any candidate, in whole steps, and different from shard to shard."""

import json
import math
from collections.abc import Callable
from itertools import pairwise

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from drivegate.contracts.current.run import observed_windows
from drivegate.contracts.current.scenarios.drawn.changes import required_point_scenarios
from drivegate.contracts.current.scenarios.drawn.families import (
    FAMILY_GROUPS,
    Family,
    base_speed_scenarios,
    drawn_scenarios,
    overspeed_scenarios,
    standstill_scenarios,
)
from drivegate.contracts.current.scenarios.feasibility import coasts
from drivegate.scenarios.drive_scale import scale_of
from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.requirements import points_of
from drivegate_cases.scenario.load import VehicleLoad
from drivegate_cases.scenario.piecewise import breakpoints, value_from, value_until
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError
from drivegate_models.units import RADIANS_PER_RPM

DRIVE = load_drive("paper-5-phase")
FAMILIES = [family for group in FAMILY_GROUPS for family in group]
MANY = settings(max_examples=60, database=None, derandomize=True, suppress_health_check=list(HealthCheck))
each_family = pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.__name__)


def load_torque(scenario: Scenario, time: float, at: Callable[..., float]) -> float:
    share, speed = at(scenario.load_profile, time), at(scenario.speed_rpm, time)
    return scenario.load.torque_at(speed, share)


@pytest.mark.one_in(3)
@each_family
def test_every_drawn_scenario_is_fair(family: Family) -> None:
    @MANY
    @given(scenario=family(DRIVE, None))
    def holds(scenario: Scenario) -> None:
        assert scenario.initial_speed_rpm == scenario.speed_rpm[0][1], "it does not start at its reference"
        for time in breakpoints([scenario.speed_rpm, scenario.load_profile], scenario.duration_s):
            for at in (value_until, value_from):
                speed = at(scenario.speed_rpm, time)
                if family is not standstill_scenarios:
                    assert speed >= 500.0 or load_torque(scenario, time, at) == 0.0, (
                        f"{scenario.name} is loaded at {speed} rpm"
                    )
        assert coasts(scenario), f"{scenario.name} brakes"

    holds()


@pytest.mark.one_in(4)
@each_family
def test_no_loaded_reference_falls_faster_than_the_load_slows_the_shaft(family: Family) -> None:
    """Written down without the harness's own rule: J·|dω/dt| is at most the least load torque on the way."""

    @MANY
    @given(scenario=family(DRIVE, None))
    def holds(scenario: Scenario) -> None:
        for (start, before), (end, after) in pairwise(scenario.speed_rpm):
            if after >= before:
                continue
            needed = DRIVE.machine.inertia_kg_m2 * (before - after) * RADIANS_PER_RPM / (end - start)
            if load_torque(scenario, start, value_from) == 0.0:
                assert (before - after) / (end - start) <= 10.0 + 1e-2, f"{scenario.name} falls too fast"
            else:
                least = min(load_torque(scenario, time, value_from) for time in (start, end))
                assert needed <= least, f"{scenario.name} needs {needed} N·m of braking, the load is {least}"

    holds()


@pytest.mark.one_in(4)
@each_family
def test_drawn_scenarios_are_whole_steps_and_survive_json(family: Family) -> None:
    @MANY
    @given(scenario=family(DRIVE, None))
    def holds(scenario: Scenario) -> None:
        speeds = [speed for _, speed in scenario.speed_rpm]
        assert all(speed % 5.0 == 0.0 for speed in speeds), f"speeds {speeds} are no whole steps"
        if not isinstance(scenario.load, VehicleLoad):
            shares = [share for _, share in scenario.load_profile]
            assert all(math.isclose(20.0 * share, round(20.0 * share)) for share in shares), shares
        read = parse_document(json.loads(scenario.to_json()), Scenario, "the file")
        assert read == scenario, f"{scenario.name} is another run after it was written and read"

    holds()


@pytest.mark.one_in(4)
@each_family
def test_the_last_steady_stretch_can_be_judged(family: Family) -> None:
    @MANY
    @given(scenario=family(DRIVE, None))
    def holds(scenario: Scenario) -> None:
        scale, (start, end) = scale_of(DRIVE), observed_windows(scenario)[-1]
        assert end == scenario.duration_s, f"{scenario.name} ends without a judged stretch"
        assert end - start >= scale.shortest_window_s - 1e-9
        assert start >= scale.settling_s

    if family is not base_speed_scenarios:
        holds()


@pytest.mark.nightly
@MANY
@given(speeds=st.tuples(st.integers(550, 1500), st.integers(550, 1500)), data=st.data())
def test_a_declared_speed_range_limits_what_is_drawn(speeds: tuple[int, int], data: st.DataObject) -> None:
    lowest, highest = float(min(speeds)), float(max(speeds))
    for group in range(len(FAMILY_GROUPS)):
        scenario = data.draw(drawn_scenarios(DRIVE, (lowest, highest), group=group))
        outside = [speed for _, speed in scenario.speed_rpm if not lowest <= speed <= highest]
        assert not outside, f"{scenario.name} is outside of {lowest} to {highest} rpm"


def test_a_candidate_for_other_speeds_is_refused_in_one_sentence() -> None:
    with pytest.raises(InputError, match=r"100 to 300 rpm, but is checked under load from 550 to 1500 rpm"):
        drawn_scenarios(DRIVE, (100.0, 300.0))


def test_the_required_points_are_reached_in_any_order() -> None:
    point, orders = points_of(DRIVE)[0], set()

    @MANY
    @given(scenario=required_point_scenarios(DRIVE, None))
    def holds(scenario: Scenario) -> None:
        end = scenario.duration_s
        assert value_until(scenario.speed_rpm, end) == point.speed_rpm
        assert load_torque(scenario, end, value_until) == point.torque_n_m
        loaded, turning = scenario.load_profile[-1][0], scenario.speed_rpm[-1][0]
        orders.add((len(scenario.load_profile) > 2, len(scenario.speed_rpm) > 1, loaded < turning))

    holds()
    assert {(True, True, True), (True, True, False), (False, True, True)} <= orders, (
        "some order is never drawn"
    )


def test_no_point_is_required_where_the_ripple_is_not_limited() -> None:
    unlimited = load_drive("star-3-phase").replaced(ripple_percent=None)
    assert required_point_scenarios(unlimited, None).is_empty
    assert required_point_scenarios(DRIVE, (600.0, 1400.0)).is_empty


def test_families_that_do_not_fit_the_speed_range_draw_nothing() -> None:
    assert overspeed_scenarios(DRIVE, (550.0, 1500.0)).is_empty
    assert base_speed_scenarios(DRIVE, (550.0, 1500.0)).is_empty
