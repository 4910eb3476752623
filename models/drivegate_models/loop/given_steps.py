"""Steps of a controller on Senses that are given, not fed back: no plant is in this loop."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.calling import call_step
from drivegate_models.compilation.kernels import unallocating
from drivegate_models.contract.current.records import SENSE
from drivegate_models.contract.layout import LAYOUTS
from drivegate_models.loop.duty_command import duty_command_status
from drivegate_models.loop.exchange import COMPLETED, command_status, make_exchange
from drivegate_models.loop.loop_inputs import SteppedController


class GivenSenses(NamedTuple):
    """What the steps are made of."""

    step_address: int
    state_address: int
    senses: NDArray[Any]
    """What is sensed, shape (n,) of the contract's sense; sizes and addresses in it are not used."""
    currents: NDArray[np.float64]
    """Their phase currents, shape (n, m) (A)."""
    sense: NDArray[Any]
    """What the controller sees, shape (1,)."""
    sensed_currents: NDArray[np.float64]
    """What that points to, shape (m,) (A)."""
    currents_address: int
    """Address of these."""
    command: NDArray[Any]
    """What it answers, shape (1,) of the contract's command."""
    fresh: NDArray[Any]
    """What a command is before the step, shape (1,)."""
    progress: NDArray[np.int64]
    """Shape (1,): number of steps begun, watched from another process."""
    kept: NDArray[Any]
    """Receives the commands, shape (k,); those after its end are not kept."""


def _steps_until(status_of: Callable[[Any], int]) -> Callable[[GivenSenses], tuple[int, int]]:
    """Make the steps of a contract from the function that checks its commands."""

    @unallocating
    def make_steps(given: GivenSenses) -> tuple[int, int]:
        senses, sense, command, kept = given.senses, given.sense, given.command, given.kept
        for k in range(senses.size):
            sense[0] = senses[k]
            sense[0].struct_size = sense.itemsize
            sense[0].phase_currents = given.currents_address
            for phase in range(given.currents.shape[1]):
                given.sensed_currents[phase] = given.currents[k, phase]
            command[0] = given.fresh[0]
            # Count before the call, so that a monitor knows in which step a controller hangs.
            given.progress[0] = k + 1
            call_step(given.step_address, given.state_address, sense.ctypes.data, command.ctypes.data)
            if k < kept.size:
                kept[k] = command[0]
            status = status_of(command[0])
            if status != COMPLETED:
                return status, k
        return COMPLETED, senses.size

    return make_steps


MAKE_STEPS: Final[Mapping[str, Callable[[GivenSenses], tuple[int, int]]]] = {
    "current": _steps_until(command_status),
    "duty": _steps_until(duty_command_status),
}
"""For each contract, the steps of a controller that has been reset, through given Senses: the last command's status
and the number of steps that were answered; the next one is what another status than `COMPLETED` is about."""


def given_senses(
    controller: SteppedController, senses: NDArray[Any], currents: NDArray[np.float64]
) -> GivenSenses:
    """Return what `MAKE_STEPS` takes, for a controller that has been reset.

    `senses`, shape (n,): what it senses, as records of its contract. `currents`, shape (n, m): the phase currents (A).
    """
    exchange = make_exchange(LAYOUTS[senses.dtype], currents.shape[1], controller)
    return GivenSenses(
        step_address=exchange.step_address,
        state_address=exchange.state_address,
        senses=np.ascontiguousarray(senses),
        currents=np.ascontiguousarray(currents, np.float64),
        sense=exchange.sense,
        sensed_currents=exchange.sensed_currents,
        currents_address=exchange.sensed_currents.ctypes.data,
        command=exchange.command,
        fresh=exchange.fresh,
        progress=exchange.progress,
        kept=exchange.kept,
    )


def senses_of(
    signals: NDArray[np.float64], phases: int, control_period: float
) -> tuple[NDArray[Any], NDArray[np.float64]]:
    """Make Senses from the signals of a script.

    `signals`, shape (n, 4): speed reference and speed (rad/s), current magnitude sum (A) and mean voltage of the
    half-sources (V). `phases`: number of phases m. `control_period`: time between two steps (s). Returns `senses`,
    shape (n,): what is sensed; `currents`, shape (n, m): the phase currents (A): equal shares of the sum, with
    alternating signs.
    """
    senses = np.zeros(len(signals), SENSE)
    senses["time"] = np.arange(len(signals)) * control_period
    senses["phase_count"] = phases
    names = ("speed_reference", "speed", "current_magnitude_sum", "half_supply_voltage")
    for name, values in zip(names, signals.T, strict=True):
        senses[name] = values
    return senses, signals[:, 2:3] / phases * np.where(np.arange(phases) % 2, -1.0, 1.0)
