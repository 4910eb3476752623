"""Drawn changes of load, speed reference and supply, and vehicles."""

from __future__ import annotations

import math

from hypothesis import strategies as st

from drivegate.contracts.current.scenarios.building import steady_scenario, vehicle_scenario
from drivegate.contracts.current.scenarios.drawn.steps import change_times, loaded_speeds, shares, steady_runs
from drivegate.contracts.current.scenarios.feasibility import COASTING_SHARE
from drivegate.scenarios.changes import (
    pulsed,
    stepped,
    with_load_shares,
    with_speed,
    with_supply,
)
from drivegate.scenarios.drive_scale import scale_of, tidy
from drivegate.scenarios.speed_range import SpeedRange
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.units import RADIANS_PER_RPM

_MASSES = (3, 4)
_GEARS = (6, 8)


def load_step_scenarios(
    drive: DriveDocument, speed_range: SpeedRange | None = None
) -> st.SearchStrategy[Scenario]:
    """Draw steps of the load, up or down, lasting or soon taken back."""
    tenth = scale_of(drive).tenth_s

    def build(
        constant_power: bool, back: int, at: float, before: float, after: float, speed: float
    ) -> Scenario:
        whole = steady_scenario(drive, speed, power_share=1.0, constant_power=constant_power)
        changes = [(0.0, before), (at, after)]
        if back:
            changes.append((tidy(at + tenth * back), before))
        return with_load_shares(whole, *changes)

    return st.builds(
        build,
        st.booleans(),
        st.one_of(st.just(0), st.integers(1, 30)),
        change_times(drive),
        shares(),
        shares(),
        loaded_speeds(drive, speed_range),
    )


def speed_step_scenarios(
    drive: DriveDocument, speed_range: SpeedRange | None = None
) -> st.SearchStrategy[Scenario]:
    """Draw changes of the speed reference under load: up at once or as a ramp, down slower than the shaft coasts."""
    tenth = scale_of(drive).tenth_s

    def build(
        constant_power: bool, at: float, longer: int, share: float, before: float, after: float
    ) -> Scenario:
        faster = max(before, after)
        run = steady_scenario(drive, faster, power_share=share, constant_power=constant_power)
        over = tenth * longer
        if after < before:
            # At the higher speed a constant power load is lightest.
            torque = drive.rating.rated_power_w * share / (faster * RADIANS_PER_RPM)
            fastest = COASTING_SHARE * torque / drive.machine.inertia_kg_m2
            least = (before - after) * RADIANS_PER_RPM / fastest
            over += tenth * math.ceil(least / tenth)
        return with_speed(run, stepped(before, after, at, over_s=over))

    return st.builds(
        build,
        st.booleans(),
        change_times(drive),
        st.integers(0, 30),
        shares(),
        loaded_speeds(drive, speed_range),
        loaded_speeds(drive, speed_range),
    )


def supply_scenarios(
    drive: DriveDocument, speed_range: SpeedRange | None = None
) -> st.SearchStrategy[Scenario]:
    """Draw dips and swells of the supply, for a moment or for good."""
    tenth = scale_of(drive).tenth_s

    def build(swell: bool, tenths: int, at: float, percent: int, run: Scenario) -> Scenario:
        share = round(1.0 + (percent if swell else -percent) / 100.0, 2)
        if tenths == 0:
            return with_supply(run, stepped(1.0, share, at))
        return with_supply(run, pulsed(1.0, share, at, tidy(tenth * tenths)))

    return st.builds(
        build,
        st.booleans(),
        st.integers(0, 10),
        change_times(drive),
        st.integers(1, 10),
        steady_runs(drive, speed_range),
    )


def vehicle_scenarios(
    drive: DriveDocument, speed_range: SpeedRange | None = None
) -> st.SearchStrategy[Scenario]:
    """Draw runs of a light vehicle, on a flat road at first."""

    def build(mass: int, gear: int, at: float, half_percents: int, speed: float) -> Scenario:
        grade = stepped(0.0, 0.5 * half_percents, at) if half_percents else ((0.0, 0.0),)
        return vehicle_scenario(drive, speed, mass_units=mass, gear_units=gear, grade_percent=grade)

    return st.builds(
        build,
        st.sampled_from(_MASSES),
        st.sampled_from(_GEARS),
        change_times(drive),
        st.integers(0, 2),
        loaded_speeds(drive, speed_range),
    )
