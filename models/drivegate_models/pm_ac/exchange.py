"""What passes between a closed loop of duty ratios and its controller in one control period."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.calling import call_step
from drivegate_models.compilation.kernels import inlined
from drivegate_models.contract.duty.records import DUTY_COMMAND, duty_command_record, duty_sense_record
from drivegate_models.loop.duty_command import duty_command_status


class DutyExchange(NamedTuple):
    """The records through which loop and controller talk, and where the controller is."""

    sense: NDArray[Any]
    """Shape (1,) of DUTY_SENSE."""
    command: NDArray[Any]
    """Shape (1,) of DUTY_COMMAND."""
    fresh: NDArray[Any]
    """What a command is before the step, shape (1,) of DUTY_COMMAND."""
    kept: NDArray[Any]
    """Receives the command of each step, shape (steps,) of DUTY_COMMAND or more."""
    progress: NDArray[np.int64]
    """Shape (1,): number of steps begun, watched from another process."""
    sensed_currents: NDArray[np.float64]
    """Shape (3,) (A)."""
    step_address: int
    """Address of the controller's step."""
    state_address: int
    """Address of its state."""
    sense_address: int
    """Address of `sense`."""
    command_address: int
    """Address of `command`."""


def make_exchange(
    steps: int,
    step_address: int,
    state_address: int,
    progress: NDArray[np.int64] | None,
    kept: NDArray[Any] | None,
) -> DutyExchange:
    """Make the records of a run of so many steps, those that are not given included."""
    currents = np.zeros(3)
    sense, command, fresh = duty_sense_record(currents), duty_command_record(), duty_command_record()
    return DutyExchange(
        sense,
        command,
        fresh,
        # Every entry is written before it is read.
        np.empty(steps, DUTY_COMMAND) if kept is None else kept,
        np.zeros(1, np.int64) if progress is None else progress,
        currents,
        step_address,
        state_address,
        sense.ctypes.data,
        command.ctypes.data,
    )


@inlined
def write_sense(
    exchange: DutyExchange,
    currents: NDArray[np.float64],
    link: float,
    reference: float,
    time: float,
    angle: float,
    speed: float,
) -> None:
    """Write what there is to sense at the start of a period.

    Parameters
    ----------
    exchange : DutyExchange
        Receives it.
    currents : ndarray, shape (3,)
        Of the phases (A).
    link : float
        Voltage of the link (V).
    reference : float
        Of speed (rad/s) or torque (N m).
    time : float
        What the controller's clock shows (s).
    angle, speed : float
        Of the shaft (rad, rad/s).
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
def ask_controller(exchange: DutyExchange, step: int) -> None:
    """Call the controller's step and keep its command.

    Parameters
    ----------
    exchange : DutyExchange
        With what is sensed; receives the command.
    step : int
        Number of the control period.
    """
    exchange.command[0] = exchange.fresh[0]
    # Counted before the call, so that whoever watches knows in which step a controller hangs.
    exchange.progress[0] = step + 1
    call_step(exchange.step_address, exchange.state_address, exchange.sense_address, exchange.command_address)
    exchange.kept[step] = exchange.command[0]


@inlined
def take_command(
    exchange: DutyExchange, ratios: NDArray[np.float64], legs: NDArray[np.int64], place: int
) -> int:
    """Take over the command of a step.

    Parameters
    ----------
    exchange : DutyExchange
        With the command.
    ratios, legs : ndarray, shape (2, 3)
        Duty ratios (1) and states of the legs, now and after the delay; changed.
    place : int
        Which of both the command is for.

    Returns
    -------
    int
        `COMPLETED`, or why it is no command.
    """
    command = exchange.command[0]
    status = duty_command_status(command)
    legs[place, 0] = command.first_leg
    legs[place, 1] = command.second_leg
    legs[place, 2] = command.third_leg
    ratios[place, 0] = command.first_duty
    ratios[place, 1] = command.second_duty
    ratios[place, 2] = command.third_duty
    return status
