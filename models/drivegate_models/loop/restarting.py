"""Reset of a controller during a run, as by a watchdog, while the drive continues."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.calling import call_step
from drivegate_models.compilation.kernels import inlined
from drivegate_models.loop.exchange import STOPPED, Exchange, step_controller


class Restarts(NamedTuple):
    """The resets of a controller during a run."""

    steps: NDArray[np.int64]
    """The steps before which it is reset, increasing, shape (n,)."""
    address: int
    """Address of a function with the arguments of a step that resets the controller; it stops the run if that fails."""


def no_restarts() -> Restarts:
    """Return the restarts of a controller that is never reset."""
    return Restarts(np.zeros(0, np.int64), 0)


@inlined
def restart_if_due(exchange: Any, restarts: Restarts, done: int, step: int) -> tuple[bool, int]:
    """Reset the controller before a step for which a restart is due.

    `exchange`: the records between loop and controller; its command is overwritten if the reset fails. `done`: number
    of restarts done before this step. `step`: number of the step in the run, from 0. Returns `has_failed`: true if the
    reset failed; `done`: number of restarts done, including one before this step.
    """
    if done >= restarts.steps.size or restarts.steps[done] > step:
        return False, done
    call_step(restarts.address, exchange.state_address, exchange.sense_address, exchange.command_address)
    return bool(exchange.command[0].struct_size < 0), done + 1


@inlined
def step_or_restart(exchange: Exchange, restarts: Restarts, done: int, step: int) -> tuple[int, int]:
    """Call the controller's step, after a reset if one is due.

    `exchange`: the records between loop and controller; its command is overwritten. `done`: number of restarts done
    before this step. `step`: number of the step in the run, from 0. Returns `status`: status of `step_controller`;
    `STOPPED` if the reset failed; `done`: number of restarts done, including one before this step.
    """
    has_failed, done = restart_if_due(exchange, restarts, done, step)
    if has_failed:
        return STOPPED, done
    return step_controller(exchange, step), done


@inlined
def steps_since(restarts: Restarts, done: int, step: int) -> int:
    """Return the number of a step counted from the controller's last reset.

    `done`: number of restarts done, including one before this step. `step`: number of the step in the run, from 0.
    Result: number of the step since the last reset, from 0; `step` if there was none.
    """
    since: int = step - restarts.steps[done - 1] if done > 0 else step
    return since


@inlined
def waits_again(restarts: Restarts, done: int, step: int, waiting: int) -> bool:
    """Return True if a step is among the first after the controller's last reset, in which the bridge is off.

    `done`: number of restarts done, including one before this step. `step`: number of the step in the run, from 0.
    `waiting`: number of steps with the bridge off after each.
    """
    return bool(done > 0 and step < restarts.steps[done - 1] + waiting)
