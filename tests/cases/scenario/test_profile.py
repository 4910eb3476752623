from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from drivegate_cases.documents.document import parse_document
from drivegate_cases.scenario.piecewise import Profile, value_from, value_until
from drivegate_cases.scenario.profile import Dwell, dwells, profile_arrays
from drivegate_cases.scenario.scenario import Scenario


def scenario(mapping: dict[str, Any], **changes: Any) -> Scenario:
    return parse_document(mapping | changes, Scenario, "here")


def test_arrays_hold_the_points() -> None:
    times, values = profile_arrays(((0.0, 1.0), (1.0, 2.0), (1.0, 3.0)), 0.0005)
    np.testing.assert_array_equal(times, [0.0, 1.0, 1.0])
    np.testing.assert_array_equal(values, [1.0, 2.0, 3.0])
    assert times.dtype == values.dtype == np.float64
    assert times.flags.c_contiguous
    assert values.flags.c_contiguous


def test_a_ramp_is_no_dwell(scenario_mapping: dict[str, Any]) -> None:
    assert dwells(scenario(scenario_mapping)) == (
        Dwell(start=0.2, end=1.0, speed_rpm=1500.0, load_factor=1.0, supply_v=48.0),
    )


def test_a_step_of_anything_ends_a_dwell(scenario_mapping: dict[str, Any]) -> None:
    run = scenario(
        scenario_mapping,
        duration_s=4.0,
        speed_rpm=[[0, 1500], [1, 1500], [1, 1000]],
        supply_v=[[0, 48], [2, 48], [2, 43], [3, 43], [3, 48]],
        load={"kind": "constant_torque", "torque_nm": 5.0, "factor": [[0, 1]]},
    )
    assert [(dwell.start, dwell.end) for dwell in dwells(run)] == [(0, 1), (1, 2), (2, 3), (3, 4)]
    assert [dwell.speed_rpm for dwell in dwells(run)] == [1500, 1000, 1000, 1000]
    assert [dwell.supply_v for dwell in dwells(run)] == [48, 48, 43, 48]
    assert dwells(run)[0].duration == 1.0


def test_a_point_that_changes_nothing_does_not_end_a_dwell(scenario_mapping: dict[str, Any]) -> None:
    run = scenario(
        scenario_mapping,
        speed_rpm=[[0, 1500], [0.4, 1500], [0.5, 1500], [0.5, 1500]],
        load={"kind": "locked"},
    )
    assert dwells(run) == (Dwell(0.0, 1.0, 1500.0, 1.0, 48.0),)


def test_a_run_of_ramps_has_no_dwell(scenario_mapping: dict[str, Any]) -> None:
    assert dwells(scenario(scenario_mapping, speed_rpm=[[0, 1500], [1, 1600]])) == ()


@st.composite
def small_profiles(draw: st.DrawFn) -> Profile:
    """Draw a profile of two values, on tenths of a second, with steps, ramps and superfluous points."""
    levels = st.lists(st.sampled_from([1.0, 2.0]), min_size=1, max_size=2)
    tenths = sorted(draw(st.sets(st.integers(1, 10), max_size=5)))
    return tuple((tenth / 10.0, level) for tenth in [0, *tenths] for level in draw(levels))


@given(small_profiles(), small_profiles(), small_profiles())
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_dwells_are_maximal_and_constant(
    scenario_mapping: dict[str, Any], speed: Profile, factor: Profile, supply: Profile
) -> None:
    run = scenario(
        scenario_mapping,
        speed_rpm=speed,
        supply_v=supply,
        load={"kind": "constant_torque", "torque_nm": 1.0, "factor": factor},
    )
    found = dwells(run)
    for dwell in found:
        assert dwell.duration > 0.0
    for before, after in pairwise(found):
        assert before.end <= after.start, f"{before} and {after} overlap"
        assert before.end < after.start or conditions(before) != conditions(after), (
            f"{before} and {after} are one dwell"
        )
    for tenth in range(10):
        start, end = tenth / 10.0, (tenth + 1) / 10.0
        here = [value_from(points, start) for points in (speed, factor, supply)]
        still = here == [value_until(points, end) for points in (speed, factor, supply)]
        covering = [conditions(dwell) for dwell in found if dwell.start <= start and end <= dwell.end]
        assert covering == ([here] if still else []), (
            f"from {start} to {end} s: {covering}, conditions {here}"
        )


def conditions(dwell: Dwell) -> list[float]:
    return [dwell.speed_rpm, dwell.load_factor, dwell.supply_v]


def test_the_conditions_of_a_dwell_cannot_be_changed() -> None:
    with pytest.raises(AttributeError):
        Dwell(0.0, 1.0, 1500.0, 1.0, 48.0).end = 2.0  # type: ignore[misc]
