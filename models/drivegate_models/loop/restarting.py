"""Starting a controller anew in mid-run, as a watchdog does, while the drive runs on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.calling import call_step
from drivegate_models.compilation.kernels import inlined
from drivegate_models.loop.exchange import STOPPED, Exchange, step_controller


class Restarts(NamedTuple):
    """When a controller is reset in mid-run, and how."""

    steps: NDArray[np.int64]
    """The steps before which it is reset, increasing, shape (n,)."""
    address: int
    """Address of a function that takes the arguments of a step and resets it; it stops the run where that fails."""


def no_restarts() -> Restarts:
    """Leave a controller alone.

    Returns
    -------
    Restarts
        None at all.
    """
    return Restarts(np.zeros(0, np.int64), 0)


@inlined
def step_or_restart(exchange: Exchange, restarts: Restarts, done: int, step: int) -> tuple[int, int]:
    """Call the controller's step, after a reset where one is due.

    Parameters
    ----------
    exchange : Exchange
        The records; the command is written anew.
    restarts : Restarts
        All of them.
    done : int
        Number of those that have been.
    step : int
        Number of the step, from 0.

    Returns
    -------
    status : int
        As `step_controller` has it; `STOPPED` too where the reset failed.
    done : int
        Number of restarts that have been.
    """
    if done < restarts.steps.size and restarts.steps[done] <= step:
        done += 1
        call_step(restarts.address, exchange.state_address, exchange.sense_address, exchange.command_address)
        if exchange.command[0].struct_size < 0:
            return STOPPED, done
    return step_controller(exchange, step), done


@inlined
def steps_since(restarts: Restarts, done: int, step: int) -> int:
    """Return the number of steps that a controller has made since its reset.

    Parameters
    ----------
    restarts : Restarts
        All of them.
    done : int
        Number of those that have been.
    step : int
        Number of the step in the run, from 0.

    Returns
    -------
    int
        Number of the step since the last reset, from 0.
    """
    since: int = step - restarts.steps[done - 1] if done > 0 else step
    return since
