"""All checks of controllers that answer with duty ratios, in the order in which they are reported."""

from __future__ import annotations

from typing import Final

from drivegate.checks.check import Check
from drivegate.checks.every_contract import DET_1, TIM_1
from drivegate.contracts.duty.checks.accuracy import ACC_1, ROB_5
from drivegate.contracts.duty.checks.commands import DUT_1
from drivegate.contracts.duty.checks.current import EFF_1, MTP_1, OVC_1, OVC_2
from drivegate.contracts.duty.checks.decoupling import DEC_1
from drivegate.contracts.duty.checks.estimate import EST_1
from drivegate.contracts.duty.checks.failures import SAF_1
from drivegate.contracts.duty.checks.link import LNK_1, LNK_2, LNK_3, LNK_4
from drivegate.contracts.duty.checks.power import DUTY_PWR_1
from drivegate.contracts.duty.checks.ripple import DTM_1, RIP_4
from drivegate.contracts.duty.checks.sensorless.changes import SLS_4, SLS_5
from drivegate.contracts.duty.checks.sensorless.lost import SLS_7
from drivegate.contracts.duty.checks.sensorless.starting import SLS_1, SLS_6
from drivegate.contracts.duty.checks.sensorless.steady import SLS_2, SLS_3, SLS_8
from drivegate.contracts.duty.checks.speed_response import ROB_4
from drivegate.contracts.duty.checks.starting import STA_1
from drivegate.contracts.duty.checks.steps import STP_1
from drivegate.contracts.duty.checks.symmetry import SYM_1
from drivegate.contracts.duty.checks.thermal import THM_1, THM_2, THM_3
from drivegate.contracts.duty.checks.weakening import FWK_1, FWK_2, FWK_3

DUTY_CHECKS: Final[tuple[Check, ...]] = (
    DUTY_PWR_1,
    DUT_1,
    ACC_1,
    STP_1,
    DEC_1,
    FWK_1,
    FWK_2,
    FWK_3,
    RIP_4,
    DTM_1,
    MTP_1,
    EFF_1,
    OVC_1,
    OVC_2,
    STA_1,
    SYM_1,
    EST_1,
    ROB_4,
    ROB_5,
    SAF_1,
    LNK_1,
    LNK_2,
    LNK_3,
    LNK_4,
    THM_1,
    THM_2,
    THM_3,
    SLS_1,
    SLS_2,
    SLS_3,
    SLS_4,
    SLS_5,
    SLS_6,
    SLS_7,
    SLS_8,
    DET_1,
    TIM_1,
)
"""Every check of this contract; those that are also of the other one have the same identifiers there."""
