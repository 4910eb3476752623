"""Plain scenarios from few numbers: one speed under one load, base speed, a vehicle."""

from __future__ import annotations

import math

from drivegate.contracts.current.scenarios.feasibility import COASTING_SHARE
from drivegate.scenarios.changes import (
    coming_on_to,
    pulsed,
    stepped,
    with_drift,
    with_load_factor,
    with_speed,
)
from drivegate.scenarios.drive_scale import scale_of, tidy
from drivegate.scenarios.title import titled
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import rounded
from drivegate_cases.scenario.load import ConstantPowerLoad, ConstantTorqueLoad, VehicleLoad
from drivegate_cases.scenario.piecewise import Profile
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.units import RADIANS_PER_RPM

TORQUE_DIGITS = 3
"""Digits that the torque of a load is rounded to."""
STANDSTILL_UNITS = 2.0
"""Units of time for which a reference stays at zero (1)."""


def coming_on(drive: DriveDocument) -> Profile:
    """Return the shares of a load that comes on at the beginning, and stays."""
    return coming_on_to(scale_of(drive).load_ramp_s, 1.0)


def steady_scenario(
    drive: DriveDocument, speed_rpm: float, *, power_share: float, constant_power: bool
) -> Scenario:
    scale = scale_of(drive)
    power = tidy(drive.rating.rated_power_w * power_share)
    load: ConstantPowerLoad | ConstantTorqueLoad
    if constant_power:
        load = ConstantPowerLoad(kind="constant_power", power_w=power, factor=coming_on(drive))
    else:
        torque = rounded(power / (speed_rpm * RADIANS_PER_RPM), TORQUE_DIGITS)
        load = ConstantTorqueLoad(kind="constant_torque", torque_nm=torque, factor=coming_on(drive))
    return titled(
        Scenario(
            name="steady",
            drive=drive,
            duration_s=tidy(scale.load_ramp_s + scale.dwell_s),
            initial_speed_rpm=speed_rpm,
            speed_rpm=((0.0, speed_rpm),),
            load=load,
        )
    )


def base_speed_scenario(
    drive: DriveDocument, start_rpm: float, top_rpm: float, fall_rpm_per_s: float
) -> Scenario:
    """Make an unloaded run from below base speed to above it, and back unless the rate of the fall is 0."""
    scale = scale_of(drive)
    end_rpm = drive.rating.base_speed_rpm - scale.speed_step_rpm
    rise_until = tidy(math.ceil(2.0 + (top_rpm - start_rpm) / (20.0 * scale.speed_grain_rpm)) * scale.tenth_s)
    fall_from = tidy(rise_until + 0.5 * scale.time_unit_s)
    fall_until = fall_from + (top_rpm - end_rpm) / (fall_rpm_per_s or math.inf)
    fall = ((fall_from, top_rpm), (round(fall_until, 3), end_rpm)) if fall_rpm_per_s else ()
    scenario = Scenario(
        name="base-speed",
        drive=drive,
        duration_s=round(fall_until + scale.time_unit_s, 1),
        initial_speed_rpm=start_rpm,
        speed_rpm=(
            (0.0, start_rpm),
            (tidy(2.0 * scale.tenth_s), start_rpm),
            (rise_until, top_rpm),
            *fall,
        ),
        load=ConstantTorqueLoad(kind="constant_torque", torque_nm=0.0, factor=((0.0, 0.0),)),
    )
    return titled(scenario)


def lifted_scenario(run: Scenario, at_s: float, lasts_s: float, lifted: float) -> Scenario:
    """Lift a driven wheel from the ground for a time, and set it down: the load goes and comes back.

    On the ground the inertia is the nameplate's. `lifted`: factor on it while the wheel is lifted.
    """
    factor = (*coming_on(run.drive), *pulsed(1.0, 0.0, at_s, lasts_s)[1:])
    return with_drift(with_load_factor(run, factor), inertia=pulsed(1.0, lifted, at_s, lasts_s))


def vehicle_scenario(
    drive: DriveDocument, speed_rpm: float, *, mass_units: int, gear_units: int, grade_percent: Profile
) -> Scenario:
    """Make a run of a light vehicle at a steady speed; its mass and gear are in units of what the drive can move."""
    scale = scale_of(drive)
    load = VehicleLoad(
        kind="vehicle",
        mass_kg=tidy(mass_units * scale.mass_unit_kg),
        wheel_radius_m=0.25,
        gear_ratio=tidy(gear_units * scale.gear_unit),
        rolling_resistance=0.012,
        drag_area_m2=scale.drag_area_m2,
        grade_percent=grade_percent,
    )
    return titled(
        Scenario(
            name="vehicle",
            drive=drive,
            duration_s=tidy(grade_percent[-1][0] + scale.dwell_s),
            initial_speed_rpm=speed_rpm,
            speed_rpm=((0.0, speed_rpm),),
            load=load,
        )
    )


def plain_scenario(drive: DriveDocument) -> Scenario:
    """Make the run without any fact: rated torque at the highest required speed."""
    return steady_scenario(drive, drive.rating.highest_speed_rpm, power_share=1.0, constant_power=False)


def standstill_scenario(
    drive: DriveDocument,
    speed_rpm: float,
    *,
    torque_nm: float,
    at_s: float,
    over_s: float,
    begins: bool = False,
) -> Scenario:
    """Make a run that begins at standstill, or comes to it and leaves it again, under a constant torque."""
    scale = scale_of(drive)
    torque = rounded(torque_nm, TORQUE_DIGITS)
    load = ConstantTorqueLoad(kind="constant_torque", torque_nm=torque, factor=coming_on(drive))
    run = steady_scenario(drive, speed_rpm, power_share=0.5, constant_power=False).replaced(load=load)
    if begins:
        return with_speed(run, stepped(0.0, speed_rpm, at_s, over_s=over_s))
    fall = COASTING_SHARE * load.torque_nm / drive.machine.inertia_kg_m2 / RADIANS_PER_RPM
    down = tidy(at_s + scale.tenth_s * math.ceil(speed_rpm / fall / scale.tenth_s))
    up = tidy(down + scale.units(STANDSTILL_UNITS))
    return with_speed(
        run,
        ((0.0, speed_rpm), (at_s, speed_rpm), (down, 0.0), (up, 0.0), (tidy(up + over_s), speed_rpm)),
    )
