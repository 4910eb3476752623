"""One run of a controller through a scenario: from plain data to what the closed loop observed."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from dataclasses import replace
from math import degrees, floor, pi
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.controller import Controller, show_drive
from drivegate.candidates.fault import OVERWRITTEN_SIZE, CandidateFault
from drivegate.containment.contained_controller import CommandPlayer
from drivegate.containment.messages import AnyController
from drivegate.containment.playback import Wrap, run_loop
from drivegate.containment.protocol import CloseLoop
from drivegate.contracts.given_steps import RecordingController
from drivegate.scenarios.drive_scale import scale_of
from drivegate.scenarios.plant_inputs import (
    common_inputs,
    plant_converters,
    plant_dropouts,
    plant_encoder,
    plant_hall,
    restart_steps,
)
from drivegate_cases.drive.limits import mean_time
from drivegate_cases.scenario.profile import dwells
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import HallSensors, IdealSensors, ShuntSensors
from drivegate_models.contract.layout import CURRENT
from drivegate_models.errors import HarnessFault
from drivegate_models.loop.closed_loop import ClosedLoopRun, PreparedLoop
from drivegate_models.loop.exchange import STOPPED
from drivegate_models.loop.loop_inputs import CurrentLoopInputs, SteppedController
from drivegate_models.loop.restarting import Restarts
from drivegate_models.loop.sensing import sensors
from drivegate_models.loop.step_recording import row_layout
from drivegate_models.units import RPM

PrepareLoop: TypeAlias = Callable[
    [CurrentLoopInputs, SteppedController, Restarts | None], PreparedLoop[ClosedLoopRun]
]
"""Makes a run of a controller, already reset, against the plant of one kind of drive ready to begin."""


def plant_sensors(scenario: Scenario) -> sensors.Sensors:
    """Make the sensors of a scenario, as at its start."""
    dropouts = plant_dropouts(scenario)
    gains, offsets = np.ones(scenario.drive.machine.phases), np.zeros(scenario.drive.machine.phases)
    for error in scenario.current_errors:
        gains[error.phase - 1], offsets[error.phase - 1] = error.gain, error.offset_a
    given = scenario.sensors
    assert not isinstance(given, ShuntSensors), "such sensors are of drives that are given duty ratios"
    if isinstance(given, IdealSensors):
        return sensors.ideal_sensors(scenario.drive.machine.phases, dropouts, gains, offsets)
    generator = np.random.default_rng(scenario.seed)
    converters = plant_converters(given, generator, gains, offsets)
    if isinstance(given, HallSensors):
        return sensors.real_sensors(converters, dropouts, hall=plant_hall(scenario, given, generator))
    return sensors.real_sensors(converters, dropouts, encoder=plant_encoder(scenario, given))


def run_in_closed_loop(
    prepare: PrepareLoop,
    scenario: Scenario,
    controller: AnyController,
    *,
    power_window: float = 0.0,
    trace_every: int = 0,
    wrap: Wrap | None = None,
    kept: NDArray[Any] | None = None,
    sees_plant: bool = False,
) -> ClosedLoopRun:
    """Reset a controller and run it through a scenario, against the plant of a closed loop.

    `kept` receives the command of each step. With `sees_plant` the controller is shown the plant as it is, whatever the
    sensors that commutate it.
    """
    nameplate = scenario.nameplate()
    given = plant_sensors(scenario)
    inputs = CurrentLoopInputs(
        **common_inputs(scenario),
        base_speed=nameplate.base_speed,
        sensors=sensors.showing_the_plant(given) if sees_plant else given,
    )
    observed = replace(
        inputs,
        windows=observed_windows(scenario),
        power_window=power_window,
        mean_time=mean_time(scenario.drive),
        trace_every=trace_every,
    )
    show_drive(controller, scenario.drive)
    order = CloseLoop(prepare, inputs, restart_steps(scenario))
    run: ClosedLoopRun = run_loop(
        order,
        controller,
        nameplate,
        scenario.control_periods,
        refusal_of,
        observed=observed,
        kept=kept,
        wrap=wrap,
    )
    return run


def refusal_of(command: Any, status: int) -> str:
    """Return why a command ended a run although the controller itself reports no fault."""
    if status == STOPPED:
        return OVERWRITTEN_SIZE
    values = ", ".join(f"{name} = {command[name]}" for name in CURRENT.outputs)
    return f"the command is not finite: {values}"


def plant_state(
    prepare: PrepareLoop, scenario: Scenario, commands: NDArray[Any], step: int
) -> dict[str, Any]:
    """Find the plant's state at the start of a step by playing the recorded commands back."""
    machine = scenario.drive.machine
    rows = np.zeros(step + 1, row_layout(CURRENT, machine.phases))
    recorders: list[RecordingController] = []

    def recording(player: Controller) -> Controller:
        recorders.append(RecordingController(player, rows))
        return recorders[-1]

    # The sensors stay, since Hall switches commutate the plant.
    plain = scenario.replaced(dropouts=(), glitches=(), current_errors=(), restarts_s=())
    player = CommandPlayer(commands[: step + 1])
    # The player stops the run after its last command.
    with contextlib.suppress(CandidateFault):
        run_in_closed_loop(prepare, plain, player, wrap=recording, sees_plant=True)
    if recorders[-1].steps != len(rows):
        raise HarnessFault(f"the recorded commands, played back, do not reach step {step}")
    sense = CURRENT.sensed(rows["sense"][step], rows["currents"][step])
    return {
        "speed": sense.speed,
        "speed_rpm": sense.speed * RPM,
        "electrical_angle_deg": degrees(_angle(rows["sense"]["speed"][:step], scenario)),
        "phase_currents": sense.phase_currents,
        "half_supply_voltage": sense.half_supply_voltage,
    }


def _angle(speeds: NDArray[np.float64], scenario: Scenario) -> float:
    """Turn by the speed of each control period as the closed loop does, from 0 (rad)."""
    angle, turning = 0.0, scenario.drive.machine.pole_pairs * 1.0
    for speed in speeds.tolist():
        turned = angle + turning * speed * scenario.control_period_s
        angle = turned - 2.0 * pi * floor(turned * (0.5 / pi))
    return angle


def observed_windows(scenario: Scenario) -> list[tuple[float, float]]:
    """Find the stretches in which convergence is judged: from the settling time into each long dwell to its end."""
    scale = scale_of(scenario.drive)
    return [
        (dwell.start + scale.settling_s, dwell.end)
        for dwell in dwells(scenario)
        if dwell.duration >= scale.settling_s + scale.shortest_window_s - 1e-9
    ]
