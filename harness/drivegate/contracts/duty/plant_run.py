"""A run on a PM AC drive: the sensors and the failure of a scenario, and what answers it."""

from __future__ import annotations

import math
from math import degrees
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegate.containment.contained_controller import CommandPlayer, Wrap
from drivegate.containment.messages import AnyController
from drivegate.contracts.duty.run import BRIDGE_ON, DutyClosedLoopRun, IdleBridge, PrepareDutyLoop, run_duty
from drivegate.scenarios.plant_inputs import plant_converters, plant_dropouts, plant_encoder, plant_hall
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import SHUNTS, ShuntSensors, position_of
from drivegate_models.loop.sensing.converters import exact_converters
from drivegate_models.loop.sensing.encoder import Encoder
from drivegate_models.machine.rotor_frame import phase_currents
from drivegate_models.pm_ac import failure
from drivegate_models.pm_ac.loop_records import TRACE
from drivegate_models.pm_ac.sensing import (
    DC_LINK,
    IN_LINE,
    LOW_SIDE,
    DutySensors,
    ShaftErrors,
    ideal_duty_sensors,
    no_shaft_errors,
    real_duty_sensors,
)
from drivegate_models.units import RPM

_FAILURES = {
    "open-phase": failure.OPEN_PHASE,
    "stuck-current": failure.STUCK_CURRENT,
    "lost-position": failure.LOST_POSITION,
    "locked-rotor": failure.LOCKED_ROTOR,
    "lost-edge": failure.LOST_EDGE,
    "slip": failure.SLIP,
}
_SHUNTS = {"in-line": IN_LINE, "low-side": LOW_SIDE, "link": DC_LINK}


def duty_run(
    prepare: PrepareDutyLoop,
    scenario: Scenario,
    controller: AnyController,
    wrap: Wrap | None = None,
    idle: IdleBridge = BRIDGE_ON,
    *,
    follows_current: bool = False,
) -> DutyClosedLoopRun:
    """Reset a controller and run it through a scenario, once."""
    seen, fails = duty_sensors(scenario), _duty_failure(scenario)
    return run_duty(
        prepare, TRACE, scenario, controller, seen, fails, wrap, idle, follows_current=follows_current
    )


def plant_state(
    prepare: PrepareDutyLoop, scenario: Scenario, commands: NDArray[Any], step: int
) -> dict[str, Any]:
    """Find the plant at the start of a step: speed, angle and link, and currents at the end of the step before."""
    run = duty_run(prepare, scenario, CommandPlayer(commands))
    speed, angle, link = (float(run.column(name)[step]) for name in ("speed", "angle", "link"))
    direct, quadrature = (
        float(run.column(name)[step - 1]) if step else 0.0 for name in ("direct", "quadrature")
    )
    currents = phase_currents(np.array([direct]), np.array([quadrature]), np.array([angle]))[0]
    return {
        "speed": speed,
        "speed_rpm": speed * RPM,
        "electrical_angle_deg": degrees(angle),
        "phase_currents": currents.tolist(),
        "direct_current": direct,
        "quadrature_current": quadrature,
        "link_voltage": link,
    }


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
        errors=_shaft_errors(given),
        dropouts=plant_dropouts(scenario),
    )


def _shaft_errors(given: ShuntSensors) -> ShaftErrors:
    """Make the errors of a sensor of the shaft that has neither lines nor edges."""
    errors = ShaftErrors(
        True,
        math.radians(given.eccentricity_deg),
        math.radians(given.eccentric_from_deg),
        given.sine_offset,
        given.cosine_offset,
        given.track_gain,
        math.radians(given.track_phase_deg),
        given.latency_s,
    )
    return errors if any(errors[1:]) else no_shaft_errors()


def _ideal_sensors(scenario: Scenario) -> DutySensors:
    """Make sensors without errors; edges of the shaft that the drive states come in their places."""
    position = position_of(scenario.sensors, scenario.drive)
    if position == "exact":
        return ideal_duty_sensors(plant_dropouts(scenario))
    converters = exact_converters(np.ones(3), np.zeros(3))
    in_place = SHUNTS.model_copy(update={"placement_error_deg": 0.0, "hysteresis_deg": 0.0})
    if position == "encoder":
        return real_duty_sensors(
            converters, encoder=_encoder(scenario, in_place), dropouts=plant_dropouts(scenario)
        )
    hall = plant_hall(scenario, in_place, np.random.default_rng(0))
    return real_duty_sensors(converters, hall=hall, dropouts=plant_dropouts(scenario))


def _encoder(scenario: Scenario, given: ShuntSensors) -> Encoder:
    """Make an encoder whose count is zero at the shaft's angle 0, but for the error of its alignment."""
    electrical = math.radians(scenario.initial_angle_deg + given.encoder_error_deg)
    return plant_encoder(scenario, given, electrical / scenario.drive.machine.pole_pairs)


def _duty_failure(scenario: Scenario) -> failure.Failure:
    given = scenario.failure
    if given is None:
        return failure.make_failure()
    slipped = math.radians(given.slip_deg or 0.0) / scenario.drive.machine.pole_pairs
    first = given.first_period(scenario.control_period_s)
    return failure.make_failure(_FAILURES[given.kind], first, given.phase - 1, slipped)
