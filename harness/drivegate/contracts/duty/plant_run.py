"""A run on a PM AC drive: the sensors and the failure of a scenario, and what answers it."""

from __future__ import annotations

import hashlib
import math
from dataclasses import replace
from functools import partial
from math import degrees
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.python.bridge import PythonController
from drivegate.containment.contained_controller import CommandPlayer, ContainedController
from drivegate.containment.messages import AnyController
from drivegate.containment.playback import Wrap, run_loop
from drivegate.containment.protocol import CloseLoop
from drivegate.contracts.duty.current_reference import quadrature_profile
from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.run import (
    BRIDGE_ON,
    DutyClosedLoopRun,
    IdleBridge,
    PrepareDutyLoop,
    duty_nameplate,
    refusal_of,
)
from drivegate.contracts.given_steps import RecordingController
from drivegate.scenarios.plant_inputs import (
    common_inputs,
    plant_converters,
    plant_course,
    plant_dropouts,
    plant_encoder,
    plant_hall,
    restart_steps,
)
from drivegate_cases.scenario.control_periods import first_period_from
from drivegate_cases.scenario.load import DynamometerLoad
from drivegate_cases.scenario.profile import released_s
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import SHUNTS, ShuntSensors, position_of
from drivegate_models.contract.layout import DUTY
from drivegate_models.loop.schedule import Course
from drivegate_models.loop.sensing.converters import exact_converters
from drivegate_models.loop.sensing.encoder import Encoder
from drivegate_models.machine.rotor_frame import phase_currents
from drivegate_models.pm_ac import failure
from drivegate_models.pm_ac.loop_inputs import DutyLoopInputs
from drivegate_models.pm_ac.loop_records import TRACE
from drivegate_models.pm_ac.mean_voltages import MeanVoltages, sensed_mean_voltages
from drivegate_models.pm_ac.sensing import (
    DC_LINK,
    IN_LINE,
    LOW_SIDE,
    DutySensors,
    ShaftErrors,
    empty_past,
    ideal_duty_sensors,
    no_shaft_errors,
    real_duty_sensors,
)
from drivegate_models.pm_ac.turning import Turning
from drivegate_models.pm_ac.winding import Winding
from drivegate_models.units import RPM

_FAILURES = {
    "open-phase": failure.OPEN_PHASE,
    "stuck-current": failure.STUCK_CURRENT,
    "lost-position": failure.LOST_POSITION,
    "locked-rotor": failure.LOCKED_ROTOR,
    "lost-edge": failure.LOST_EDGE,
    "slip": failure.SLIP,
}
MOST_PERIODS: Final = 200_000_000
"""Most control periods before a run in which a compiled controller sees its shaft turn; they take half a minute (1)."""
MOST_PERIODS_OF_SLOW: Final = 50_000
"""Most of them for one that is interpreted, emulated, or a program of its own (1)."""
_DIGEST_BITS: Final = 63
_AFTER_A_STEP: Final = 1e-6
"""Time of a control period at which a step at its start has been taken, in control periods (1)."""
_SHUNTS = {"in-line": IN_LINE, "low-side": LOW_SIDE, "link": DC_LINK}


def duty_run(
    prepare: PrepareDutyLoop,
    scenario: Scenario,
    controller: AnyController,
    wrap: Wrap | None = None,
    idle: IdleBridge = BRIDGE_ON,
    *,
    follows_current: bool = False,
    steps: NDArray[Any] | None = None,
) -> DutyClosedLoopRun:
    """Reset a controller and run it through a scenario, once; a fault of its own is raised.

    `steps` receives what it senses and answers in the run, of every n-th step if there is no room for more.
    """
    inputs = DutyLoopInputs(
        **common_inputs(scenario),
        sensors=duty_sensors(scenario),
        failure=_duty_failure(scenario),
        torque_reference=_torque_reference(scenario, follows_current),
        resting=idle.resting,
        waiting=idle.waiting,
        released=_release_period(scenario),
        turning=turned_before(scenario, controller),
        winding=plant_winding(scenario),
        mean_voltages=_mean_voltages(scenario),
    )
    before = 0 if inputs.turning is None else inputs.turning.periods
    order = CloseLoop(prepare, inputs, restart_steps(scenario), DUTY, steps_before=before)
    nameplate = duty_nameplate(scenario, follows_current=follows_current)
    # Commands that are played back need no turns to count.
    judged = replace(inputs, turning=None) if isinstance(controller, ContainedController) else None
    if steps is not None:
        skipped = idle.periods + (before if judged is None else 0)
        every = -(-scenario.control_periods // len(steps))
        wrap = partial(RecordingController, rows=steps, every=every, skipped=skipped)
    count = idle.periods + scenario.control_periods
    because = partial(refusal_of, has_sensor=position_of(scenario.sensors, scenario.drive) != "none")
    run = run_loop(order, controller, nameplate, count, because, observed=judged, wrap=wrap)
    commands = run.commands[run.before :]
    if follows_current:
        _show_torque(run.trace, scenario)
    return DutyClosedLoopRun(
        columns=TRACE,
        trace=run.trace,
        commands=commands,
        totals=run.totals,
        worst_balance=run.worst_balance,
        shaft=run.shaft,
        digest=_digest(commands),
    )


def _release_period(scenario: Scenario) -> int | None:
    released = released_s(scenario)
    return None if released is None else first_period_from(released, scenario.control_period_s)


def turned_before(scenario: Scenario, controller: AnyController) -> Turning | None:
    """Return the control periods in which a controller sees the last turns before a run; None without any.

    At its initial speed the shaft makes whole turns in them, which changes that speed by less than its share of a turn.
    """
    if isinstance(controller, CommandPlayer):
        return None
    if isinstance(controller, ContainedController):
        is_slow = not controller.is_compiled
    else:
        is_slow = isinstance(controller, PythonController)
    most = MOST_PERIODS_OF_SLOW if is_slow else MOST_PERIODS
    period = scenario.control_period_s
    turns = min(abs(scenario.turns_before), int(abs(scenario.initial_speed_rpm) / 60.0 * period * most))
    if turns == 0:
        return None
    periods = round(turns / (abs(scenario.initial_speed_rpm) / 60.0 * period))
    speed = math.copysign(2.0 * math.pi * turns / (periods * period), scenario.initial_speed_rpm)
    return Turning(periods, speed, duty_sensors(scenario))


def _torque_reference(scenario: Scenario, follows_current: bool) -> Course | None:
    if not isinstance(scenario.load, DynamometerLoad):
        return None
    torques = scenario.load.torque_reference_nm
    return plant_course(scenario, quadrature_profile(scenario, torques) if follows_current else torques)


def _show_torque(trace: NDArray[np.float64], scenario: Scenario) -> None:
    """Put the torque of the scenario back where the loop has kept the q current that the controller got for it."""
    times = (np.arange(len(trace)) + _AFTER_A_STEP) * scenario.control_period_s
    points = np.array(scenario.torque_reference_profile)
    trace[:, TRACE.index("torque_reference")] = np.interp(times, points[:, 0], points[:, 1])


def _digest(commands: NDArray[Any]) -> int:
    # Processors have instructions for this one: a tenth of a run went into a digest that has none.
    whole = hashlib.sha256(np.ascontiguousarray(commands).view(np.uint8).data).digest()[:8]
    return int.from_bytes(whole, "little") >> (64 - _DIGEST_BITS)


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


def plant_winding(scenario: Scenario) -> Winding | None:
    """Make the thermal node of a drive that states one."""
    thermal = duty_document(scenario.drive).thermal
    return (
        None if thermal is None else thermal.plant(scenario.control_period_s, scenario.winding_temperature_c)
    )


def _mean_voltages(scenario: Scenario) -> MeanVoltages | None:
    """Make the sensor of the means of the terminals' voltages, if the drive states it."""
    sensing = duty_document(scenario.drive).sensing
    if sensing is None or not sensing.mean_voltages:
        return None
    return sensed_mean_voltages(scenario.control_period_s, sensing.voltage_filter_s)


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
        errors=_shaft_errors(given, scenario.control_period_s),
        has_position=given.position != "none",
        dropouts=plant_dropouts(scenario),
    )


def _shaft_errors(given: ShuntSensors, control_period: float) -> ShaftErrors:
    """Make the errors of a sensor of the shaft that has neither lines nor edges, for a control period (s)."""
    errors = (
        math.radians(given.eccentricity_deg),
        math.radians(given.eccentric_from_deg),
        given.sine_offset,
        given.cosine_offset,
        given.track_gain,
        math.radians(given.track_phase_deg),
        given.latency_s,
    )
    if not any(errors):
        return no_shaft_errors()
    return ShaftErrors(True, *errors, empty_past(given.latency_s, control_period))


def _ideal_sensors(scenario: Scenario) -> DutySensors:
    """Make sensors without errors; edges of the shaft that the drive states come in their places."""
    position = position_of(scenario.sensors, scenario.drive)
    if position == "exact":
        return ideal_duty_sensors(plant_dropouts(scenario))
    converters = exact_converters(np.ones(3), np.zeros(3))
    in_place = SHUNTS.model_copy(update={"placement_error_deg": 0.0, "hysteresis_deg": 0.0})
    if position == "none":
        return real_duty_sensors(converters, has_position=False, dropouts=plant_dropouts(scenario))
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
