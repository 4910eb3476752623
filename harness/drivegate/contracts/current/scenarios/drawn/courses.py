"""Drawn courses of load and speed: loads that come slowly, vanish or change again and again, and standstill."""

from __future__ import annotations

from hypothesis import strategies as st

from drivegate.contracts.current.scenarios.building import (
    standstill_scenario,
    steady_scenario,
)
from drivegate.contracts.current.scenarios.drawn.steps import (
    LOAD_STEP,
    Drawn,
    change_times,
    loaded_speeds,
    shares,
)
from drivegate.scenarios.changes import coming_on_to, pulsed, repeated, stepped, with_load_factor
from drivegate.scenarios.drive_scale import DriveScale, SpeedRange, scale_of, tidy
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.piecewise import Profile
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.units import RADIANS_PER_RPM

_HEAVIEST_AT_STANDSTILL = 0.5


def load_course_scenarios(drive: DriveDocument, speed_range: SpeedRange | None = None) -> Drawn:
    """Draw loads that come or go as a ramp, vanish for a while or for good, or change twenty times in a row."""
    scale = scale_of(drive)

    def build(
        course: str, constant_power: bool, at: float, before: float, tenths: int, after: float, speed: float
    ) -> Scenario:
        whole = steady_scenario(drive, speed, power_share=1.0, constant_power=constant_power)
        lasts = tidy(scale.tenth_s * tenths)
        return with_load_factor(whole, load_course(course, before, after, at, lasts, scale))

    def drawn(course: str, lasting: st.SearchStrategy[int], other: st.SearchStrategy[float]) -> Drawn:
        speeds = loaded_speeds(drive, speed_range)
        return st.builds(
            build, st.just(course), st.booleans(), change_times(drive), shares(), lasting, other, speeds
        )

    lasting, nothing = st.integers(1, 30), st.just(0)
    return st.one_of(
        drawn("ramp", lasting, shares()),
        drawn("vanishing", lasting, st.just(0.0)),
        drawn("gone", nothing, st.just(0.0)),
        drawn("repeated", nothing, shares()),
    )


def load_course(
    course: str, before: float, after: float, at_s: float, lasts_s: float, scale: DriveScale
) -> Profile:
    """Make a course of shares of the load, from nothing at first."""
    match course:
        case "ramp":
            profile = stepped(before, after, at_s, over_s=lasts_s)
        case "vanishing":
            profile = pulsed(before, 0.0, at_s, lasts_s)
        case "gone":
            profile = stepped(before, 0.0, at_s)
        case "repeated":
            profile = repeated(before, after, at_s, every_s=scale.repeated_every_s)
        case _:
            raise AssertionError(f"there is no course '{course}'")
    return coming_on_to(scale.load_ramp_s, before, profile[1:])


def standstill_scenarios(drive: DriveDocument, speed_range: SpeedRange | None = None) -> Drawn:
    """Draw references that begin at zero, or go down to it and up again, under loads that no advance is needed for."""
    if speed_range is not None and speed_range[0] > 0.0:
        return st.nothing()

    tenth = scale_of(drive).tenth_s

    def build(begins: bool, slower: int, steps: int, at: float, speed: float) -> Scenario:
        power, base_speed = drive.rating.rated_power_w, drive.rating.base_speed_rpm * RADIANS_PER_RPM
        heaviest = _HEAVIEST_AT_STANDSTILL * power / base_speed
        rated = power / (speed * RADIANS_PER_RPM)
        torque = LOAD_STEP * steps * min(heaviest, rated)
        return standstill_scenario(
            drive, speed, torque_nm=torque, at_s=at, over_s=tenth * slower, begins=begins
        )

    return st.builds(
        build,
        st.booleans(),
        st.one_of(st.just(0), st.integers(10, 30)),
        st.integers(2, 18),
        change_times(drive),
        loaded_speeds(drive, speed_range),
    )
