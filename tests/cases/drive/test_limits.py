"""Limits of a drive: as its file has them, or as they follow from its rating."""

import pytest

from drivegate_cases.documents.document import Section
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.drive_file import drive_schema
from drivegate_cases.drive.limits import Limit, limits_of, mean_time, nearest_step, rounded, time_unit
from drivegate_cases.drive.pm_ac.requirements import PmAcRequirements
from drivegate_cases.drive.requirements import RequiredPoint, Requirements, points_of
from drivegate_models.errors import InputError

PAPER = load_drive("paper-5-phase")
UNSTATED = PAPER.replaced(requirements={})


def test_the_drive_of_the_paper_states_its_limits() -> None:
    assert vars(limits_of(PAPER)) == {
        "speed_tolerance_rpm": 5.0,
        "power_tolerance": 0.005,
        "angle_tolerance_deg": 1.0,
        "settling_s": 6.0,
        "optimum_tolerance": 0.02,
        "ripple": 0.13,
        "closed_loop_ripple": 0.20,
    }
    assert points_of(PAPER) == (RequiredPoint(speed_rpm=1500.0, torque_n_m=9.8),)


def test_what_is_left_out_follows_from_the_rating() -> None:
    fast = UNSTATED.replaced(base_speed_rpm=1000.0, highest_speed_rpm=1800.0, rated_power_w=3000.0)
    limits = limits_of(fast)
    assert limits.speed_tolerance_rpm == 10.0, "1 % of base speed"
    assert points_of(fast) == (RequiredPoint(speed_rpm=1800.0, torque_n_m=16.333),), (
        "2.6 % above 3 kW at the highest speed"
    )


def test_a_stated_limit_holds_whatever_the_rating() -> None:
    stated = UNSTATED.replaced(speed_tolerance_rpm=3.0, settling_s=4.5, base_speed_rpm=700.0)
    assert (limits_of(stated).speed_tolerance_rpm, limits_of(stated).settling_s) == (3.0, 4.5)


@pytest.mark.parametrize(
    ("changes", "unit"),
    [
        ({}, 1.0),
        ({"inertia_kg_m2": 0.001}, 1.0),
        ({"inertia_kg_m2": 0.1}, 2.0),
        ({"inertia_kg_m2": 0.5}, 10.0),
        ({"pole_pairs": 2}, 5.0),
    ],
)
def test_times_follow_from_inertia_and_electrical_frequency(changes: dict[str, float], unit: float) -> None:
    drive = UNSTATED.replaced(**changes)
    assert time_unit(drive) == unit
    assert limits_of(drive).settling_s == 6.0 * unit
    assert mean_time(drive) == pytest.approx(0.1 * unit), "a mean of a slow drive has too few periods"


@pytest.mark.parametrize(
    ("value", "step"), [(0.96, 1.0), (3.1, 2.0), (3.3, 5.0), (7.2, 10.0), (3e4, 2e4), (0.0, 0.0)]
)
def test_steps_are_easily_read(value: float, step: float) -> None:
    assert nearest_step(value) == step


def test_small_values_keep_their_digits_when_rounded() -> None:
    assert (rounded(9.54930, 3), rounded(0.0123456, 3)) == (9.549, 0.0123)


@pytest.mark.parametrize("speed", [500.0, 2001.0])
def test_a_point_at_a_speed_without_a_search_is_refused(speed: float) -> None:
    point = RequiredPoint(speed_rpm=speed, torque_n_m=1.0)
    with pytest.raises(
        InputError, match=rf"has one at {speed:g} rpm, but must be above the base speed of 500"
    ):
        PAPER.replaced(point=(point,))


def test_a_settling_time_is_a_whole_number_of_tenths() -> None:
    with pytest.raises(InputError, match="must be a whole number of tenths"):
        PAPER.replaced(settling_s=1.25)


@pytest.mark.parametrize(
    ("key", "least"),
    [
        ("speed_tolerance_rpm", "1e-06"),
        ("power_tolerance_percent", "1e-07"),
        ("angle_tolerance_deg", "0.0001"),
        ("optimum_tolerance_percent", "0.001"),
        ("ripple_percent", "1e-07"),
        ("closed_loop_ripple_percent", "1e-07"),
    ],
)
def test_a_limit_that_would_judge_rounding_is_refused_with_the_least_and_the_reason(
    key: str, least: str
) -> None:
    for value in (1e-300, 0.0, -1.0, 0.999 * float(least)):
        with pytest.raises(InputError) as refused:
            PAPER.replaced(**{key: value})
        assert f"{key}' is {value!r}, but must be at least {least}, since " in str(refused.value)
    assert PAPER.replaced(**{key: float(least)}).value(key) == float(least)
    assert drive_schema()["$defs"]["Requirements"]["properties"][key]["minimum"] == float(least)


def test_the_rules_give_the_paper_s_own_limits() -> None:
    assert vars(limits_of(UNSTATED)) == vars(limits_of(PAPER))
    assert points_of(UNSTATED) == points_of(PAPER)


@pytest.mark.parametrize("table", [Requirements, PmAcRequirements])
def test_every_key_of_the_requirements_but_the_points_declares_a_limit(table: type[Section]) -> None:
    undeclared = {
        key
        for key, field in table.model_fields.items()
        if not any(isinstance(limit, Limit) for limit in field.metadata)
    }
    assert undeclared <= {"point"}


def test_a_limit_that_no_key_declares_is_refused_by_its_name() -> None:
    with pytest.raises(AttributeError, match="no key of the drive's requirements declares a limit 'riple'"):
        _ = limits_of(PAPER).riple
