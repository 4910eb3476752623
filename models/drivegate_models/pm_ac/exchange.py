"""One step of a controller of duty ratios: the only place where their compiled loop calls it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.calling import call_step
from drivegate_models.compilation.kernels import inlined
from drivegate_models.loop.duty_command import duty_command_status
from drivegate_models.loop.exchange import Exchange


@inlined
def write_sense(
    exchange: Exchange,
    currents: NDArray[np.float64],
    link: float,
    reference: float,
    time: float,
    angle: float,
    speed: float,
) -> None:
    """Write the true values at the start of a period into the Sense.

    - `exchange`: its `sense` and `sensed_currents` are overwritten.
    - `currents`, shape (3,): phase currents (A).
    - `link`: voltage of the dc link (V).
    - `reference`: reference of speed (rad/s) or torque (N m).
    - `time`: time of the controller's clock (s).
    - `angle`, `speed`: angle (rad) and speed (rad/s) of the shaft.
    """
    sense = exchange.sense
    sense[0].time = time
    sense[0].reference = reference
    sense[0].supply_voltage = link
    sense[0].angle = angle
    sense[0].speed = speed
    for leg in range(3):
        exchange.sensed_currents[leg] = currents[leg]


@inlined
def step_controller(exchange: Exchange, step: int) -> None:
    """Call the controller's step for a control period, and store its command."""
    exchange.command[0] = exchange.fresh[0]
    # Count before the call, so that a monitor knows in which step a controller hangs.
    exchange.progress[0] = step + 1
    call_step(exchange.step_address, exchange.state_address, exchange.sense_address, exchange.command_address)
    exchange.kept[step] = exchange.command[0]


@inlined
def copy_command(
    exchange: Exchange,
    ratios: NDArray[np.float64],
    legs: NDArray[np.int64],
    brakes: NDArray[np.float64],
    place: int,
) -> int:
    """Copy the command of a step, and return its status.

    - `exchange`: its `command` is read.
    - `ratios`, `legs`, shape (2, 3): duty ratios (1) and states of the legs, now and after the delay; one row is
      overwritten.
    - `brakes`, shape (2,): the same of the chopper's duty ratio (1).
    - `place`: row of the command: 0 without a delay, otherwise 1.
    - Result: status of `duty_command.duty_command_status`.
    """
    command = exchange.command[0]
    status = duty_command_status(command)
    legs[place, 0] = command.first_leg
    legs[place, 1] = command.second_leg
    legs[place, 2] = command.third_leg
    ratios[place, 0] = command.first_duty
    ratios[place, 1] = command.second_duty
    ratios[place, 2] = command.third_duty
    brakes[place] = command.brake_duty
    return status
