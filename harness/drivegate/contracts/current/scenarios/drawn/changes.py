"""Drawn changes of load, speed reference and supply, ways to the required points, and vehicles."""

from __future__ import annotations

import math

from hypothesis import strategies as st

from drivegate.contracts.current.scenarios.building import coming_on, steady_scenario, vehicle_scenario
from drivegate.contracts.current.scenarios.drawn.steps import (
    Drawn,
    change_times,
    loaded_speeds,
    shares,
    steady_runs,
)
from drivegate.contracts.current.scenarios.feasibility import COASTING_SHARE
from drivegate.scenarios.changes import (
    pulsed,
    stepped,
    with_load_factor,
    with_load_shares,
    with_speed,
    with_supply,
)
from drivegate.scenarios.drive_scale import SpeedRange, loaded_range, scale_of, tidy
from drivegate.scenarios.title import titled
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.drive.requirements import RequiredPoint, points_of
from drivegate_cases.scenario.load import ConstantTorqueLoad
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.units import RADIANS_PER_RPM

_MASSES = (3, 4)
_GEARS = (6, 8)


def load_step_scenarios(drive: DriveDocument, speed_range: SpeedRange | None = None) -> Drawn:
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


def speed_step_scenarios(drive: DriveDocument, speed_range: SpeedRange | None = None) -> Drawn:
    """Draw changes of the speed reference under load: up at once or as a ramp, down slower than the shaft coasts."""
    tenth = scale_of(drive).tenth_s

    def build(
        constant_power: bool, at: float, longer: int, share: float, before: float, after: float
    ) -> Scenario:
        faster = max(before, after)
        run = steady_scenario(drive, faster, power_share=share, constant_power=constant_power)
        # At the higher speed a constant power load is lightest.
        torque = drive.rating.rated_power_w * share / (faster * RADIANS_PER_RPM)
        over = tenth * longer + coasting_time(drive, before - after, torque)
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


def required_point_scenarios(drive: DriveDocument, speed_range: SpeedRange | None = None) -> Drawn:
    """Draw ways to the required points: load and speed reference arrive there in any order, at once or slowly."""
    tenth = scale_of(drive).tenth_s
    lowest, highest = loaded_range(drive, speed_range)
    points = [point for point in points_of(drive) if lowest <= point.speed_rpm <= highest]
    if not points or math.isinf(limits_of(drive).ripple):
        return st.nothing()

    def build(
        point: RequiredPoint, slower: tuple[int, int], at: tuple[float, float], share: float, speed: float
    ) -> Scenario:
        (load_at, speed_at), (load_over, speed_over) = at, (tenth * tenths for tenths in slower)
        load = ConstantTorqueLoad(kind="constant_torque", torque_nm=point.torque_n_m, factor=coming_on(drive))
        there = steady_scenario(drive, point.speed_rpm, power_share=1.0, constant_power=False)
        if share < 1.0:
            ramp = ((0.0, 0.0), (scale_of(drive).load_ramp_s, share))
            factor = (*ramp, *stepped(share, 1.0, load_at, over_s=load_over)[1:])
            there = with_load_factor(there.replaced(load=load), factor)
        else:
            there = titled(there.replaced(load=load))
        if speed == point.speed_rpm:
            return there
        speed_over += coasting_time(drive, speed - point.speed_rpm, share * point.torque_n_m)
        return with_speed(there, stepped(speed, point.speed_rpm, speed_at, over_s=speed_over))

    return st.builds(
        build,
        st.sampled_from(points),
        st.tuples(st.integers(0, 30), st.integers(0, 30)),
        st.tuples(change_times(drive), change_times(drive)),
        shares(),
        loaded_speeds(drive, speed_range),
    )


def coasting_time(drive: DriveDocument, slower_rpm: float, torque_nm: float) -> float:
    """Return the time in which a load slows the shaft by a speed, in whole tenths of a unit (s); 0 to go faster."""
    tenth = scale_of(drive).tenth_s
    fastest = COASTING_SHARE * torque_nm / drive.machine.inertia_kg_m2
    return tenth * math.ceil(max(slower_rpm, 0.0) * RADIANS_PER_RPM / fastest / tenth)


def supply_scenarios(drive: DriveDocument, speed_range: SpeedRange | None = None) -> Drawn:
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


def vehicle_scenarios(drive: DriveDocument, speed_range: SpeedRange | None = None) -> Drawn:
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
