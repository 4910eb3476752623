"""The scenarios that every check runs first, whatever the seed."""

from __future__ import annotations

from drivegate_cases.load import ConstantPowerLoad, ConstantTorqueLoad
from drivegate_cases.motor import Motor, load_motor
from drivegate_cases.scenario import Scenario, load_scenario

REFERENCE_MOTOR = "paper-5-phase"
"""Name of the motor that candidates are checked on."""
LOAD_RAMP_S = 0.2
"""Time in which a drawn load comes on, so that a run starts in a true steady state, unloaded at speed (s)."""
DWELL_S = 10.0
"""Length of a steady stretch: 6 s to converge and 4 s to be judged (s)."""


def steady_scenario(motor: Motor, speed_rpm: float, *, power_share: float, constant_power: bool) -> Scenario:
    """Make a run at one speed under one load.

    Parameters
    ----------
    motor : Motor
        The motor.
    speed_rpm : float
        Speed reference (rpm), above 0.
    power_share : float
        Load over the motor's rated power, at that speed (1).
    constant_power : bool
        Whether the load's power or its torque is constant.

    Returns
    -------
    Scenario
        The run.
    """
    power = motor.rated_power_w * power_share
    factor = ((0.0, 0.0), (LOAD_RAMP_S, 1.0))
    load: ConstantPowerLoad | ConstantTorqueLoad
    if constant_power:
        load = ConstantPowerLoad(kind="constant_power", power_w=power, factor=factor)
    else:
        torque = ConstantPowerLoad(kind="constant_power", power_w=power, factor=factor).torque_at(speed_rpm)
        load = ConstantTorqueLoad(kind="constant_torque", torque_nm=torque, factor=factor)
    kind = "power" if constant_power else "torque"
    return Scenario(
        name=f"steady-{speed_rpm:g}rpm-{100.0 * power_share:g}%-{kind}",
        description=f"{speed_rpm:g} rpm under a constant {kind} load of {power:g} W.",
        motor=motor,
        duration_s=LOAD_RAMP_S + DWELL_S,
        initial_speed_rpm=speed_rpm,
        speed_rpm=((0.0, speed_rpm),),
        load=load,
    )


def base_speed_scenario(motor: Motor, start_rpm: float, top_rpm: float, fall_rpm_per_s: float) -> Scenario:
    """Make an unloaded run from below base speed to above it, and back no faster than the shaft coasts.

    Parameters
    ----------
    motor : Motor
        The motor.
    start_rpm : float
        Speed at the start, below base speed (rpm).
    top_rpm : float
        Speed above base speed (rpm).
    fall_rpm_per_s : float
        Rate at which the reference comes down to 10 rpm below base speed (rpm/s).

    Returns
    -------
    Scenario
        The run.
    """
    end_rpm = motor.base_speed_rpm - 10.0
    rise_until = 0.2 + (top_rpm - start_rpm) / 1000.0
    rise_until = round(rise_until / 0.1 + 0.5) * 0.1
    fall_from = rise_until + 0.5
    fall_until = fall_from + (top_rpm - end_rpm) / fall_rpm_per_s
    duration = round(fall_until + 1.0, 1)
    return Scenario(
        name=f"base-speed-{start_rpm:g}-{top_rpm:g}rpm-{fall_rpm_per_s:g}rpm/s",
        description="Unloaded, up through base speed and slowly down through it again.",
        motor=motor,
        duration_s=duration,
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


def fixed_scenarios() -> tuple[Scenario, ...]:
    """List the scenarios that every check runs first.

    Returns
    -------
    tuple of Scenario
        The published trajectory and the lock-up, constant power over the required speed range, half load, and
        base speed in both directions.
    """
    motor = load_motor(REFERENCE_MOTOR)
    rated = [
        steady_scenario(motor, speed, power_share=1.0, constant_power=True)
        for speed in (550.0, 700.0, 900.0, 1150.0, 1350.0, 1500.0)
    ]
    half = [
        steady_scenario(motor, speed, power_share=0.5, constant_power=False)
        for speed in (600.0, 1000.0, 1500.0)
    ]
    return (
        load_scenario("lock-up"),
        load_scenario("fig5-search"),
        *rated,
        *half,
        base_speed_scenario(motor, 300.0, 520.0, 5.0),
        base_speed_scenario(motor, 480.0, 520.0, 8.0),
    )
