"""All checks, in the order in which they are reported."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from drivegate.checks.check import Check
from drivegate.checks.determinism import DET_1
from drivegate.checks.timing import TIM_1
from drivegate.contracts.current.checks.command_range import ADV_1, ADV_2, CMD_1
from drivegate.contracts.current.checks.constant_power import CPW_1, CPW_2
from drivegate.contracts.current.checks.convergence import CNV_1, CNV_2, CNV_3
from drivegate.contracts.current.checks.current import CUR_1
from drivegate.contracts.current.checks.neutral import NEU_1
from drivegate.contracts.current.checks.power import PWR_1, PWR_2
from drivegate.contracts.current.checks.profile import FLO_1
from drivegate.contracts.current.checks.ripple import RIP_1, RIP_2, RIP_3
from drivegate.contracts.current.checks.robustness import ROB_1, ROB_2, ROB_3
from drivegate.contracts.current.checks.torque_sign import TRQ_1
from drivegate.contracts.duty.checks.catalogue import DUTY_CHECKS

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

CHECKS_OF: Final[Mapping[str, tuple[Check, ...]]] = {"current": CHECKS, "duty": DUTY_CHECKS}
"""The checks of each contract."""
ALL_CHECKS: Final[Mapping[str, Check]] = {
    check.id: check for checks in (DUTY_CHECKS, CHECKS) for check in checks
}
"""A check of each identifier; of one that several contracts have, that of the first."""
CHECK_NAMES: Final[tuple[str, ...]] = tuple(
    dict.fromkeys(check.id for checks in CHECKS_OF.values() for check in checks)
)
"""Identifiers of all checks, those of the first contract first."""


def check_of(contract: str, name: str) -> Check:
    """Find a contract's check by its identifier, or that of another contract where it has none."""
    return next((check for check in CHECKS_OF[contract] if check.id == name), None) or ALL_CHECKS[name]
