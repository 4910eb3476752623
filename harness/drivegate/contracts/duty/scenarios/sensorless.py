"""The runs of a drive without a position sensor."""

from __future__ import annotations

from math import ceil
from typing import Final

from drivegate.contracts.duty.scenarios.building import (
    TORQUE_DIGITS,
    dwell_periods,
    failing,
    share_scenario,
    speed_scenario,
    start_s,
    torque_of,
)
from drivegate.contracts.duty.scenarios.drawn_range import BEYOND_SHARE, speed_of
from drivegate.contracts.duty.scenarios.overload import OVERLOAD, greatest_at_rest
from drivegate.contracts.duty.scenarios.reaching import reaction_s
from drivegate.contracts.duty.scenarios.unsensed import REACTION_S, conducts_off
from drivegate.scenarios.changes import with_scales
from drivegate.scenarios.drive_scale import rated_torque_at, tidy
from drivegate.scenarios.rotation import mirrored
from drivegate.scenarios.title import titled
from drivegate_cases.drive.limits import nearest_step, rounded
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.pm_ac.sensorless import START_TORQUE
from drivegate_cases.scenario.control_periods import first_period_from, period_start_s
from drivegate_cases.scenario.load import ConstantTorqueLoad, HoistLoad
from drivegate_cases.scenario.piecewise import Profile
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.units import RADIANS_PER_RPM

ANGLES_DEG: Final = tuple(15.0 * number for number in range(24))
"""Angles of the rotor that a start is tried from (electrical degrees)."""
LOADED_SHARE: Final = 0.8
"""Greatest load of a speed regulator without a sensor, over rated torque (1)."""
BACK_S: Final = 2.0
"""Time in which the speed has to be back after a step of the load (s)."""
LOSS_S: Final = 0.5
"""Time in which a controller tells that it has lost the rotor (s)."""
WELL_ABOVE: Final = 2.0
"""Speed from which on a load may step and parameters may differ, over the least one (1)."""
# Least time in which a load comes on slowly (s), and how far it may move the speed, over the speed (1).
_RAMP_S: Final = 1.0
_RAMP_SAG: Final = 0.2
# Time in which a reversal changes the reference by base speed (s).
_FULL_RAMP_S: Final = 1.0
_FLYING_SHARES: Final = (0.05, 0.25, 0.6, 1.0)
_PARAMETERS: Final = (
    ("resistance", 0.7),
    ("resistance", 1.3),
    ("emf_constant", 0.9),
    ("emf_constant", 1.05),
    ("inductance", 0.8),
    ("inductance", 1.2),
)


def least_rpm(drive: PmAcDocument, factor: float = 1.0) -> float:
    """Return a multiple of the least speed, rounded upward, at most the highest one (rpm)."""
    return _upward(drive, factor * drive.least_speed_rpm)


def _upward(drive: PmAcDocument, speed_rpm: float) -> float:
    grain = nearest_step(0.005 * drive.rating.base_speed_rpm)
    return min(tidy(ceil(speed_rpm / grain) * grain), drive.rating.highest_speed_rpm)


def least_loaded_rpm(drive: PmAcDocument, share: float) -> float:
    """Return the least speed at which a share of rated torque may come on at once (rpm).

    Twice the least speed, or what leaves the least speed after the time in which the load moves the shaft freely.
    """
    moved = share * rated_torque_at(drive, 0.0) * REACTION_S / drive.machine.inertia_kg_m2 / RADIANS_PER_RPM
    return max(least_rpm(drive, WELL_ABOVE), _upward(drive, drive.least_speed_rpm + moved))


def sensorless_start(drive: PmAcDocument, speed_rpm: float, share: float, angle_deg: float) -> Scenario:
    """Make a start from an angle of the rotor (electrical degrees) under a share of rated torque."""
    run = speed_scenario(
        drive,
        (speed_rpm,),
        torque_nm=torque_of(drive, speed_rpm, share),
        initial_speed_rpm=0.0,
        initial_angle_deg=angle_deg,
    )
    return _longer(run, drive.start_time_s)


def _longer(run: Scenario, added_s: float) -> Scenario:
    period = run.control_period_s
    return titled(
        run.replaced(duration_s=period_start_s(first_period_from(run.duration_s + added_s, period), period))
    )


def _load_ramp_s(drive: PmAcDocument, speed_rpm: float, share: float) -> float:
    """Return the time in which a load comes on so slowly that the slowest regulator keeps the speed (s).

    A torque that rises at a rate moves the speed by that rate times the square of the reaction time over a quarter of
    the inertia, of a regulator whose integral is four times slower than its gain.
    """
    reaction = reaction_s(drive)
    moved = 4.0 * torque_of(drive, speed_rpm, abs(share)) * reaction * reaction / drive.machine.inertia_kg_m2
    return max(_RAMP_S, tidy(ceil(10.0 * moved / (_RAMP_SAG * abs(speed_rpm) * RADIANS_PER_RPM)) / 10.0))


def slowly_loaded(drive: PmAcDocument, speed_rpm: float, share: float) -> Scenario:
    """Make a start without load to a speed, at which a load comes on slowly; a negative share drives the shaft."""
    run = sensorless_start(drive, abs(speed_rpm), 0.0, 0.0)
    on, there = run.duration_s, run.duration_s + _load_ramp_s(drive, speed_rpm, share)
    duration = start_s(drive, first_period_from(there, drive.control_period_s) + dwell_periods(drive))
    torque = torque_of(drive, speed_rpm, abs(share))
    factor: Profile = ((0.0, 0.0), (on, 0.0), (there, 1.0))
    if share < 0.0:
        load: ConstantTorqueLoad | HoistLoad = HoistLoad(kind="hoist", torque_nm=torque, factor=factor)
        run = run.replaced(speed_rpm=((0.0, -abs(speed_rpm)),))
    else:
        load = ConstantTorqueLoad(kind="constant_torque", torque_nm=torque, factor=factor)
    run = titled(run.replaced(duration_s=duration, load=load))
    return mirrored(run) if share >= 0.0 and speed_rpm < 0.0 else run


def sensorless_load_step(drive: PmAcDocument, speed_rpm: float, share: float) -> Scenario:
    """Make a start without load to a speed, at which a load comes on at once and goes again."""
    run = sensorless_start(drive, abs(speed_rpm), 0.0, 0.0)
    period = drive.control_period_s
    each = max(dwell_periods(drive), first_period_from(1.5 * BACK_S, period))
    on = round(run.duration_s / period)
    times = [start_s(drive, on + number * each) for number in range(3)]
    factor: Profile = ((0.0, 0.0), (times[0], 0.0), (times[0], 1.0), (times[1], 1.0), (times[1], 0.0))
    load = ConstantTorqueLoad(
        kind="constant_torque", torque_nm=torque_of(drive, speed_rpm, share), factor=factor
    )
    made = titled(run.replaced(duration_s=times[2], load=load))
    return mirrored(made) if speed_rpm < 0.0 else made


def sensorless_reversal(drive: PmAcDocument, speed_rpm: float, share: float) -> Scenario:
    """Make a start without load to a speed, from which the reference goes to the opposite one by a ramp."""
    run = sensorless_start(drive, abs(speed_rpm), 0.0, 0.0)
    over = 2.0 * abs(speed_rpm) / drive.rating.base_speed_rpm * _FULL_RAMP_S
    period = drive.control_period_s
    ramp = _load_ramp_s(drive, speed_rpm, share)
    loaded = start_s(drive, first_period_from(run.duration_s + ramp, period))
    begin = start_s(drive, round(loaded / period) + dwell_periods(drive))
    end = start_s(drive, first_period_from(begin + over, period))
    duration = start_s(drive, first_period_from(end + drive.start_time_s, period) + dwell_periods(drive))
    load = ConstantTorqueLoad(
        kind="constant_torque",
        torque_nm=torque_of(drive, speed_rpm, share),
        factor=((0.0, 0.0), (run.duration_s, 0.0), (loaded, 1.0)),
    )
    way: Profile = ((0.0, abs(speed_rpm)), (begin, abs(speed_rpm)), (end, -abs(speed_rpm)))
    made = titled(run.replaced(duration_s=duration, speed_rpm=way, load=load))
    return mirrored(made) if speed_rpm < 0.0 else made


def flying_start(drive: PmAcDocument, speed_rpm: float, angle_deg: float = 0.0) -> Scenario:
    """Make a run that takes over a shaft that turns at its speed reference, without a load."""
    run = speed_scenario(drive, (abs(speed_rpm),), initial_angle_deg=angle_deg)
    return mirrored(run) if speed_rpm < 0.0 else run


def lost_rotor(
    drive: PmAcDocument, speed_rpm: float, share: float, *, from_standstill: bool = False
) -> Scenario:
    """Make a run whose shaft locks: before it starts, or while it turns under a load."""
    if from_standstill:
        run = sensorless_start(drive, speed_rpm, 0.0, 0.0)
        return failing(_longer(run, 2.0 * drive.start_time_s + LOSS_S), "locked-rotor", 0.0)
    run = slowly_loaded(drive, speed_rpm, share)
    return failing(_longer(run, 2.0 * LOSS_S), "locked-rotor", run.duration_s)


def overloaded(drive: PmAcDocument, speed_rpm: float) -> Scenario:
    """Make a start to a speed, at which a load rises slowly until the shaft stops."""
    run = sensorless_start(drive, speed_rpm, 0.0, 0.0)
    greatest = greatest_at_rest(drive.plant(), 2.0 * drive.inverter.supply_voltage_v)
    on, whole = run.duration_s, run.duration_s + _RAMP_S
    torque = rounded(OVERLOAD * greatest, TORQUE_DIGITS)
    stopping_s = drive.machine.inertia_kg_m2 * speed_rpm * RADIANS_PER_RPM / ((OVERLOAD - 1.0) * greatest)
    factor: Profile = ((0.0, 0.0), (on, 0.0), (whole, 1.0))
    load = ConstantTorqueLoad(kind="constant_torque", torque_nm=torque, factor=factor)
    return titled(_longer(run, _RAMP_S + stopping_s + 2.0 * LOSS_S).replaced(load=load))


def sensorless_scenarios(drive: PmAcDocument) -> list[Scenario]:
    """List the fixed runs of a drive without a position sensor, in both senses of rotation."""
    least, twice = least_rpm(drive), least_rpm(drive, WELL_ABOVE)
    base, top = speed_of(drive, 0.0), drive.rating.highest_speed_rpm
    loaded = least_loaded_rpm(drive, LOADED_SHARE)
    fast = max(min(base, top), min(loaded, top))
    shares = (0.0, 0.5 * START_TORQUE, START_TORQUE)
    starts = [
        run if number % 4 else mirrored(run)
        for number, run in enumerate(
            sensorless_start(drive, twice, shares[number % 3], angle)
            for number, angle in enumerate(ANGLES_DEG)
        )
    ]
    slow = [
        slowly_loaded(drive, sign * speed, share)
        for speed in (least, twice, base, top)
        for sign, share in ((1.0, LOADED_SHARE), (-1.0, LOADED_SHARE), (-1.0, -LOADED_SHARE))
        # A weight drives a shaft up to base speed in the families of a drive with a sensor too.
        if share > 0.0 or speed <= base
    ]
    steps = [
        sensorless_load_step(drive, speed, LOADED_SHARE) for speed in (loaded, -loaded, fast) if speed <= top
    ]
    reversed_at = max(least_rpm(drive, 2.0 * WELL_ABOVE), tidy(0.5 * base))
    reversals = [
        sensorless_reversal(drive, sign * min(reversed_at, base), share)
        for sign, share in ((1.0, 0.0), (1.0, 0.5), (-1.0, 0.25))
    ]
    flying = [
        flying_start(drive, sign * max(least, tidy(share * top)), angle)
        for share, sign, angle in (
            (part, way, 40.0 * number) for number, part in enumerate(_FLYING_SHARES) for way in (1.0, -1.0)
        )
    ]
    lost = [
        lost_rotor(drive, base, 0.5),
        lost_rotor(drive, base, 0.0, from_standstill=True),
        mirrored(overloaded(drive, twice)),
    ]
    others = [
        with_scales(slowly_loaded(drive, speed, LOADED_SHARE), **{name: factor})
        for name, factor in _PARAMETERS
        for speed in (twice, base)
    ]
    # Of a shaft so fast that the diodes conduct, a controller sees too little.
    taken_over = [run for run in (*flying, *_torques(drive)) if not conducts_off(run, drive)]
    return [*starts, *slow, *steps, *reversals, *lost, *others, *taken_over]


def _torques(drive: PmAcDocument) -> list[Scenario]:
    """Make the runs of a held shaft through steps of the torque reference."""
    least, top = least_rpm(drive), drive.rating.highest_speed_rpm
    slow = max(speed_of(drive, -0.5), least_rpm(drive, WELL_ABOVE))
    runs = [
        share_scenario(drive, least, 0.0, 0.5, LOADED_SHARE, -LOADED_SHARE),
        share_scenario(drive, slow, 0.0, 0.9, 0.5, 0.1, 0.0),
        share_scenario(drive, speed_of(drive, 0.0), 0.0, 0.25, 0.5, 1.0, -0.6),
        share_scenario(drive, speed_of(drive, 0.5), 0.0, 0.6, -0.6),
        share_scenario(drive, top, 0.0, LOADED_SHARE, -LOADED_SHARE),
        *([share_scenario(drive, speed_of(drive, 0.5), 0.0, BEYOND_SHARE, 0.0)] if drive.weakens else ()),
    ]
    return [*runs, mirrored(runs[0]), mirrored(runs[2])]
