"""The sensors of a scenario whose controller answers with duty ratios, as at its start, and what fails in it."""

from __future__ import annotations

import math

import numpy as np

from drivegate.scenarios.plant_inputs import plant_converters, plant_encoder, plant_hall
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import SHUNTS, ShuntSensors, position_of
from drivegate_models.loop.sensing.converters import exact_converters
from drivegate_models.loop.sensing.encoder import Encoder
from drivegate_models.pm_ac import failure
from drivegate_models.pm_ac.sensing import (
    DC_LINK,
    IN_LINE,
    LOW_SIDE,
    DutySensors,
    ideal_duty_sensors,
    real_duty_sensors,
)

_FAILURES = {
    "open-phase": failure.OPEN_PHASE,
    "stuck-current": failure.STUCK_CURRENT,
    "lost-position": failure.LOST_POSITION,
    "locked-rotor": failure.LOCKED_ROTOR,
    "lost-edge": failure.LOST_EDGE,
}
_SHUNTS = {"in-line": IN_LINE, "low-side": LOW_SIDE, "link": DC_LINK}


def duty_sensors(scenario: Scenario) -> DutySensors:
    """Make them; what is drawn follows from the scenario's seed."""
    given = scenario.sensors
    if not isinstance(given, ShuntSensors):
        return _ideal_sensors(scenario)
    generator = np.random.default_rng(scenario.seed)
    phases = scenario.drive.machine.phases
    # The converter sees the whole link, whose halves the ranges of all kinds of drives are stated for.
    converters = plant_converters(given, generator, np.ones(phases), np.zeros(phases), sources=2)
    return real_duty_sensors(
        converters,
        shunt=_SHUNTS[given.shunts],
        window=given.settling_s,
        encoder=_encoder(scenario, given) if given.position == "encoder" else None,
        hall=plant_hall(scenario, given, generator) if given.position == "hall" else None,
    )


def _ideal_sensors(scenario: Scenario) -> DutySensors:
    """Make sensors without errors; edges of the shaft that the drive states come in their places."""
    position = position_of(scenario.sensors, scenario.drive)
    if position == "exact":
        return ideal_duty_sensors()
    converters = exact_converters(np.ones(3), np.zeros(3))
    in_place = SHUNTS.model_copy(update={"placement_error_deg": 0.0, "hysteresis_deg": 0.0})
    if position == "encoder":
        return real_duty_sensors(converters, encoder=_encoder(scenario, in_place))
    return real_duty_sensors(converters, hall=plant_hall(scenario, in_place, np.random.default_rng(0)))


def _encoder(scenario: Scenario, given: ShuntSensors) -> Encoder:
    """Make an encoder whose count is zero at the shaft's angle 0, but for the error of its alignment."""
    electrical = math.radians(scenario.initial_angle_deg + given.encoder_error_deg)
    return plant_encoder(scenario, given, electrical / scenario.drive.machine.pole_pairs)


def duty_failure(scenario: Scenario) -> failure.Failure:
    """Make what fails."""
    given = scenario.failure
    if given is None:
        return failure.make_failure()
    return failure.make_failure(
        _FAILURES[given.kind], given.first_period(scenario.control_period_s), given.phase - 1
    )
