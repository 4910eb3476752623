"""Plain scenarios from few numbers: one speed under one load, base speed, a vehicle."""

from __future__ import annotations

import math

from drivegate.scenarios.title import titled
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.load import ConstantPowerLoad, ConstantTorqueLoad, VehicleLoad
from drivegate_cases.scenario.piecewise import Profile
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.units import RADIANS_PER_RPM

LOAD_RAMP_S = 0.2
"""Time in which a load comes on, so that a run starts in a true steady state, unloaded at speed (s)."""
DWELL_S = 10.0
"""Length of a steady stretch: 6 s to converge and 4 s to be judged (s)."""


def steady_scenario(
    drive: DriveDocument, speed_rpm: float, *, power_share: float, constant_power: bool
) -> Scenario:
    """Make a run at one speed under one load."""
    power = tidy(drive.rating.rated_power_w * power_share)
    factor = ((0.0, 0.0), (LOAD_RAMP_S, 1.0))
    load: ConstantPowerLoad | ConstantTorqueLoad
    if constant_power:
        load = ConstantPowerLoad(kind="constant_power", power_w=power, factor=factor)
    else:
        torque = round(power / (speed_rpm * RADIANS_PER_RPM), 3)
        load = ConstantTorqueLoad(kind="constant_torque", torque_nm=torque, factor=factor)
    return titled(
        Scenario(
            name="steady",
            drive=drive,
            duration_s=LOAD_RAMP_S + DWELL_S,
            initial_speed_rpm=speed_rpm,
            speed_rpm=((0.0, speed_rpm),),
            load=load,
        )
    )


def base_speed_scenario(
    drive: DriveDocument, start_rpm: float, top_rpm: float, fall_rpm_per_s: float
) -> Scenario:
    """Make an unloaded run from below base speed to above it, and back no faster than the shaft coasts."""
    end_rpm = drive.rating.base_speed_rpm - 10.0
    rise_until = tidy(math.ceil(2.0 + (top_rpm - start_rpm) / 100.0) * 0.1)
    fall_from = tidy(rise_until + 0.5)
    fall_until = fall_from + (top_rpm - end_rpm) / fall_rpm_per_s
    scenario = Scenario(
        name="base-speed",
        drive=drive,
        duration_s=round(fall_until + 1.0, 1),
        initial_speed_rpm=start_rpm,
        speed_rpm=(
            (0.0, start_rpm),
            (0.2, start_rpm),
            (rise_until, top_rpm),
            (fall_from, top_rpm),
            (round(fall_until, 3), end_rpm),
        ),
        load=ConstantTorqueLoad(kind="constant_torque", torque_nm=0.0, factor=((0.0, 0.0),)),
    )
    return titled(scenario)


def vehicle_scenario(
    drive: DriveDocument, speed_rpm: float, *, mass_kg: float, gear_ratio: float, grade_percent: Profile
) -> Scenario:
    """Make a run of a light vehicle at a steady speed."""
    load = VehicleLoad(
        kind="vehicle",
        mass_kg=mass_kg,
        wheel_radius_m=0.25,
        gear_ratio=gear_ratio,
        rolling_resistance=0.012,
        drag_area_m2=0.6,
        grade_percent=grade_percent,
    )
    return titled(
        Scenario(
            name="vehicle",
            drive=drive,
            duration_s=tidy(grade_percent[-1][0] + DWELL_S),
            initial_speed_rpm=speed_rpm,
            speed_rpm=((0.0, speed_rpm),),
            load=load,
        )
    )


def tidy(value: float) -> float:
    """Take off what binary fractions add to sums of decimal ones."""
    return round(value, 9)
