"""Load, schedule and sensors of a scenario, as the plant takes them."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegate_cases.scenario.control_periods import seen_at_s
from drivegate_cases.scenario.courses import COURSES, Quantity
from drivegate_cases.scenario.disturbance import Dropout
from drivegate_cases.scenario.load import (
    GRAVITY,
    ConstantPowerLoad,
    ConstantTorqueLoad,
    FanLoad,
    HoistLoad,
    LockedLoad,
)
from drivegate_cases.scenario.piecewise import Profile
from drivegate_cases.scenario.profile import profile_arrays
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import HallSensors, Mcs96Sensors, ShuntSensors
from drivegate_models.loop.schedule import Conditions, Course, Schedule
from drivegate_models.loop.sensing import sensors
from drivegate_models.loop.sensing.converters import Converters, real_converters
from drivegate_models.loop.sensing.encoder import Encoder, turning_encoder
from drivegate_models.loop.sensing.hall import EDGES, Hall, turning_hall
from drivegate_models.machine import load
from drivegate_models.units import RADIANS_PER_RPM

_SIGNALS = {"speed": sensors.SPEED, "currents": sensors.CURRENTS, "supply": sensors.SUPPLY}


def common_inputs(scenario: Scenario) -> dict[str, Any]:
    """Return the fields of `drivegate_models.loop.loop_inputs.LoopInputs` for a scenario."""
    return {
        "drive": scenario.drive.plant(scenario.scales),
        "load": plant_load(scenario),
        "schedule": plant_schedule(scenario),
        "control_period": scenario.control_period_s,
        "duration": scenario.duration_s,
        "initial_speed": scenario.initial_speed_rpm * RADIANS_PER_RPM,
        "initial_angle": math.radians(scenario.initial_angle_deg),
        "clock_start": scenario.clock_start_s,
    }


def restart_steps(scenario: Scenario) -> list[int]:
    """Return the steps before which a scenario resets the controller."""
    return [round(time / scenario.control_period_s) for time in scenario.restarts_s]


def plant_load(scenario: Scenario) -> load.Load:
    given = scenario.load
    if isinstance(given, LockedLoad):
        return load.Load(load.LOCKED)
    if isinstance(given, ConstantTorqueLoad):
        return load.Load(load.CONSTANT_TORQUE, given.torque_nm)
    if isinstance(given, HoistLoad):
        return load.Load(load.HOIST, given.torque_nm)
    if isinstance(given, ConstantPowerLoad):
        return load.Load(load.CONSTANT_POWER, given.power_w)
    if isinstance(given, FanLoad):
        return load.Load(load.FAN, given.torque_nm, given.speed_rpm * RADIANS_PER_RPM)
    return load.Load(
        load.VEHICLE,
        size=given.mass_kg * GRAVITY * given.lever_m,
        rolling=given.rolling_resistance,
        drag=0.5
        * given.air_density_kg_m3
        * given.drag_area_m2
        * (given.lever_m * given.lever_m * given.lever_m),
        inertia=given.inertia_kg_m2,
    )


def plant_schedule(scenario: Scenario) -> Schedule:
    return Conditions(*(_course(scenario, COURSES[name]) for name in Conditions._fields))


def _course(scenario: Scenario, quantity: Quantity) -> Course:
    return plant_course(
        scenario, quantity.profile(scenario), quantity.keys.get(quantity.key(scenario) or "", 1.0)
    )


def plant_course(scenario: Scenario, profile: Profile, unit: float = 1.0) -> Course:
    times, values = profile_arrays(profile, scenario.control_period_s)
    return Course(times, values * unit)


def plant_converters(
    given: Mcs96Sensors | HallSensors | ShuntSensors,
    generator: np.random.Generator,
    gains: NDArray[np.float64],
    offsets: NDArray[np.float64],
    sources: int = 1,
) -> Converters:
    """Make the converters; a link of several sources is measured as a whole."""
    return real_converters(
        generator,
        gains,
        offsets,
        current_range=_stated(given.current_range_a),
        current_gain_spread=given.current_gain_spread,
        current_offset=_stated(given.current_offset_a),
        current_noise=_stated(given.current_noise_a),
        voltage_range=sources * _stated(given.voltage_range_v),
        voltage_noise=sources * _stated(given.voltage_noise_v),
        converter_bits=given.converter_bits,
    )


def plant_dropouts(scenario: Scenario) -> NDArray[np.float64]:
    """Return signal, start and end (s) of every dropout of a scenario, shape (d, 3)."""
    seen = partial(seen_at_s, control_period_s=scenario.control_period_s)
    rows = [(_signal(lost), seen(lost.start_s), seen(lost.end_s)) for lost in scenario.dropouts]
    return np.array(rows, np.float64).reshape(-1, 3)


def _signal(lost: Dropout) -> int:
    return _SIGNALS[lost.signal] if lost.phase is None else sensors.FIRST_PHASE + lost.phase - 1


def plant_encoder(
    scenario: Scenario, given: Mcs96Sensors | ShuntSensors, initial_angle: float = 0.0
) -> Encoder:
    """Make the encoder of a scenario, as at its start, where its count shows an angle of the shaft (rad)."""
    period = scenario.control_period_s
    glitches = np.array(
        [(seen_at_s(glitch.time_s, period), glitch.counts) for glitch in scenario.glitches], np.float64
    )
    return turning_encoder(
        lines=given.encoder_lines,
        speed_window=given.speed_window_s,
        clock=given.clock_s,
        control_period=period,
        initial_speed=scenario.initial_speed_rpm * RADIANS_PER_RPM,
        initial_angle=initial_angle,
        glitches=glitches.reshape(-1, 2),
    )


def plant_hall(scenario: Scenario, given: HallSensors | ShuntSensors, generator: np.random.Generator) -> Hall:
    greatest = math.radians(given.placement_error_deg)
    return turning_hall(
        pole_pairs=scenario.drive.machine.pole_pairs,
        placement_errors=greatest * generator.uniform(-1.0, 1.0, EDGES),
        greatest_error=greatest,
        hysteresis=math.radians(given.hysteresis_deg),
        clock=given.clock_s,
        initial_angle=math.radians(scenario.initial_angle_deg),
        initial_speed=scenario.initial_speed_rpm * RADIANS_PER_RPM,
    )


def _stated(value: float | None) -> float:
    assert value is not None, "a scenario's sensors are fitted to its drive"
    return value
