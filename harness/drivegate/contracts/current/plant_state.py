"""The plant's own state at one step of a recorded run, which sensors may show otherwise."""

from __future__ import annotations

import contextlib
from math import degrees, floor, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.controller import Controller
from drivegate.candidates.fault import CandidateFault
from drivegate.containment.contained_controller import CommandPlayer
from drivegate.contracts.current.run import PrepareLoop, run_in_closed_loop
from drivegate.contracts.recorded_steps import RecordingController
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.contract.layout import CURRENT
from drivegate_models.errors import HarnessFault
from drivegate_models.loop.step_recording import row_layout
from drivegate_models.units import RPM


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
