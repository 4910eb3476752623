"""Steps of a controller of duty ratios on Senses that are given, not fed back: no plant is in this loop."""

from __future__ import annotations

from drivegate_models.compilation.calling import call_step
from drivegate_models.compilation.kernels import unallocating


@unallocating
def make_duty_steps(step: int, state: int, senses: int, size: int, count: int, command: int) -> int:
    """Step a controller, already reset, through given Senses.

    Parameters
    ----------
    step, state : int
        Addresses of the controller's step function and of its state.
    senses : int
        Address of the first record of DUTY_SENSE; the others follow.
    size : int
        Size of each (bytes).
    count : int
        Number of them.
    command : int
        Address of a record of DUTY_COMMAND, which is written anew in each step.

    Returns
    -------
    int
        Number of steps made.
    """
    for k in range(count):
        call_step(step, state, senses + k * size, command)
    return count
