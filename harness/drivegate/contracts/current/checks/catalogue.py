"""All checks, in the order in which they are reported."""

from __future__ import annotations

from typing import Final

from drivegate.checks.check import Check
from drivegate.checks.every_contract import DET_1, TIM_1
from drivegate.contracts.current.checks.command_range import ADV_1, ADV_2, CMD_1
from drivegate.contracts.current.checks.constant_power import CPW_1, CPW_2
from drivegate.contracts.current.checks.convergence import CNV_1, CNV_2, CNV_3
from drivegate.contracts.current.checks.current import CUR_1, NEU_1
from drivegate.contracts.current.checks.power import PWR_1, PWR_2
from drivegate.contracts.current.checks.profile import FLO_1
from drivegate.contracts.current.checks.ripple import RIP_1, RIP_2, RIP_3
from drivegate.contracts.current.checks.robustness import ROB_1, ROB_2, ROB_3
from drivegate.contracts.current.checks.torque_sign import TRQ_1

CHECKS: Final[tuple[Check, ...]] = (
    PWR_1,
    PWR_2,
    NEU_1,
    ADV_1,
    ADV_2,
    CMD_1,
    RIP_1,
    RIP_2,
    RIP_3,
    TRQ_1,
    CNV_1,
    CNV_2,
    CNV_3,
    CPW_1,
    CPW_2,
    CUR_1,
    ROB_1,
    ROB_2,
    ROB_3,
    DET_1,
    TIM_1,
    FLO_1,
)
"""Every check of controllers that answer with a current reference and an advance angle."""
