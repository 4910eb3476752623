"""The two contracts, by what a controller answers with."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final, Literal, TypeAlias

from drivegate_models.contract.current.signals import Nameplate
from drivegate_models.contract.duty.signals import DutyNameplate
from drivegate_models.errors import InputError

ContractName: TypeAlias = Literal["current", "duty"]
AnyNameplate: TypeAlias = Nameplate | DutyNameplate

ANSWERS: Final = MappingProxyType(
    {"current": "a current reference and an advance angle", "duty": "duty ratios"}
)
"""What a controller of each contract answers with."""
HEADERS: Final = MappingProxyType({"current": "drivegate.h", "duty": "drivegate_duty.h"})
"""The header that a compiled controller of each contract is written by."""


def contract_of(nameplate: AnyNameplate) -> ContractName:
    """Return which contract a nameplate is of, and with it the run that it is for."""
    return "duty" if isinstance(nameplate, DutyNameplate) else "current"


def require_nameplate_of(contract: str, nameplate: AnyNameplate) -> None:
    """Refuse a run of another contract than a controller's."""
    required = contract_of(nameplate)
    if contract != required:
        raise InputError(other_contract(contract, required))


def other_contract(contract: str, required: str) -> str:
    """State that a controller answers by one contract, but its drive takes the other."""
    return (
        f"the controller answers with {ANSWERS[contract]}, but the drive takes {ANSWERS[required]}; run it on "
        f"a drive that takes {ANSWERS[contract]}, or state in its manifest a contract and a drive that fit"
    )
