"""The sense of rotation, and the mirror image of a run: what turns forward turns backward instead."""

from __future__ import annotations

from drivegate.scenarios.title import titled
from drivegate_cases.scenario.load import DynamometerLoad, HoistLoad, VehicleLoad
from drivegate_cases.scenario.piecewise import Profile, breakpoints, value_from, value_until
from drivegate_cases.scenario.scenario import Scenario


def sense_of(speed: float) -> float:
    """Return the sense in which a shaft turns: 1 forward and at rest, -1 backward."""
    return 1.0 if speed >= 0.0 else -1.0


def goes_backward(scenario: Scenario) -> bool:
    """Return True if a run begins with a speed backward or has a reference of one."""
    return min(scenario.initial_speed_rpm, *(speed for _, speed in scenario.speed_rpm)) < 0.0


def needs_reverse(scenario: Scenario) -> bool:
    """Return True if a run needs a drive that turns both ways: backward, by a weight, or by a torque at standstill.

    A shaft at rest is turned backward by any torque against the forward sense, and by a hoist's weight; a shaft that
    turns forward is only braked.
    """
    return goes_backward(scenario) or isinstance(scenario.load, HoistLoad) or _pulls_back_at_rest(scenario)


def _pulls_back_at_rest(scenario: Scenario) -> bool:
    if not isinstance(scenario.load, DynamometerLoad):
        return False
    profiles = scenario.speed_rpm, scenario.load.torque_reference_nm
    return any(
        value_at(profiles[1], time) < 0.0 and value_at(profiles[0], time) <= 0.0
        for time in breakpoints(profiles, scenario.duration_s)
        for value_at in (value_until, value_from)
    )


def is_mirrored(scenario: Scenario) -> bool:
    """Return True if a run has a mirror image: a hoist's weight pulls one way only."""
    return not isinstance(scenario.load, HoistLoad)


def mirrored(scenario: Scenario) -> Scenario:
    """Negate speeds, torque reference, initial angle and a road's grade; other loads oppose the rotation either way."""
    load = scenario.load
    if isinstance(load, VehicleLoad):
        load = load.model_copy(update={"grade_percent": _negated(load.grade_percent)})
    if isinstance(load, DynamometerLoad):
        load = load.model_copy(update={"torque_reference_nm": _negated(load.torque_reference_nm)})
    return titled(
        scenario.replaced(
            initial_speed_rpm=_negative(scenario.initial_speed_rpm),
            speed_rpm=_negated(scenario.speed_rpm),
            initial_angle_deg=_negative(scenario.initial_angle_deg) % 360.0,
            turns_before=-scenario.turns_before,
            load=load,
        )
    )


def _negated(profile: Profile) -> Profile:
    return tuple((time, _negative(value)) for time, value in profile)


def _negative(value: float) -> float:
    """Negate a number, without a sign of zero that would show in names."""
    return -value if value else 0.0
