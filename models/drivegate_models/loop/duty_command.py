"""The conditions that a command of duty ratios must meet for a run to continue; checks judge its ranges."""

from __future__ import annotations

from math import isfinite
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.contract.duty.signals import LEG_LOW, LEG_OFF
from drivegate_models.loop.exchange import COMPLETED, NOT_FINITE, STOPPED

BAD_LEG: Final = 4
"""Status of a run, in addition to those of `exchange` and `loop_kernel`: a leg's state is not in the contract."""


@inlined
def duty_command_status(command: Any) -> int:
    """Return the status of a command: `COMPLETED` if the run may continue.

    `command`: as written by the controller; duty ratios outside 0 to 1 are allowed here. Result: `COMPLETED`,
    `STOPPED`, `NOT_FINITE` (duty ratios) or `BAD_LEG`.
    """
    if command.struct_size < 0:
        return STOPPED
    if not (isfinite(command.first_duty) and isfinite(command.second_duty) and isfinite(command.third_duty)):
        return NOT_FINITE
    for leg in (command.first_leg, command.second_leg, command.third_leg):
        if not LEG_OFF <= leg <= LEG_LOW:
            return BAD_LEG
    return COMPLETED
