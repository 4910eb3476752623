"""What a command of duty ratios must be for a run to go on; what is only out of its range is for a check to judge."""

from __future__ import annotations

from math import isfinite
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.contract.duty.signals import LEG_LOW, LEG_OFF
from drivegate_models.loop.exchange import COMPLETED, NOT_FINITE, STOPPED

BAD_LEG: Final = 4
"""Status of a run: a leg's state is none of the contract's; those of `exchange` and `loop_kernel` besides."""


@inlined
def duty_command_status(command: Any) -> int:
    """Look at a command.

    Parameters
    ----------
    command : record of DUTY_COMMAND
        As it was given.

    Returns
    -------
    int
        `COMPLETED`, or `STOPPED`, `NOT_FINITE` or `BAD_LEG`.
    """
    if command.struct_size < 0:
        return STOPPED
    if not (isfinite(command.first_duty) and isfinite(command.second_duty) and isfinite(command.third_duty)):
        return NOT_FINITE
    for leg in (command.first_leg, command.second_leg, command.third_leg):
        if not LEG_OFF <= leg <= LEG_LOW:
            return BAD_LEG
    return COMPLETED
