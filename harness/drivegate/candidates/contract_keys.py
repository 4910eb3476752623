"""The one table of what a manifest states for one contract alone; keys for some kinds of candidate are in `KINDS`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from drivegate.candidates.declaration import NOTHING_DECLARED, Declaration
from drivegate_models.errors import InputError


@dataclass(frozen=True)
class ContractKey:
    """A key of a manifest that one contract alone has."""

    contract: str
    field: str
    """Its field in a `Declaration`."""
    others: str
    """Why candidates of the other contract have none."""


_LEGS, _DUTIES = "whose legs are no candidate's", "whose duty ratios are no candidate's"
_ANGLES = "which has no advance angle"
CONTRACT_KEYS: Final[Mapping[str, ContractKey]] = {
    "references": ContractKey("duty", "references", "whose controllers follow a speed"),
    "detects": ContractKey("duty", "detects", _LEGS),
    "reverses": ContractKey("duty", "reverses", "whose runs all turn forward"),
    "reads_enable": ContractKey("duty", "reads_enable", _LEGS),
    "calibration_time_s": ContractKey("duty", "calibration_time_s", _LEGS),
    "current_bandwidth_rad_s": ContractKey("duty", "current_bandwidth", "whose currents are no candidate's"),
    "control_every": ContractKey("duty", "control_every", "whose carrier is no candidate's"),
    "update_delay": ContractKey("duty", "update_delay", _DUTIES),
    "modulation": ContractKey("duty", "modulation", _DUTIES),
    "flowchart": ContractKey("current", "flowchart", _ANGLES),
    "speed_range_rpm": ContractKey(
        "current", "speed_range_rpm", "whose drives state by 'speed_range_rpm' at which speeds they are run"
    ),
    "estimates_power": ContractKey("current", "estimates_power", "whose estimates of power no check judges"),
    "power_window_s": ContractKey("current", "power_window_s", "whose estimates of power no check judges"),
}
"""Keys of a manifest that one contract alone has, by name."""


def refuse_other_keys(declaration: Declaration, contract: str | None, where: str = "") -> None:
    """Refuse what a manifest states that its candidate's contract has nothing of; None is a contract not known yet."""
    for name, key in CONTRACT_KEYS.items():
        is_stated = getattr(declaration, key.field) != getattr(NOTHING_DECLARED, key.field)
        if is_stated and contract not in (None, key.contract):
            raise InputError(
                f"{where}the key '{name}' is for the contract '{key.contract}', but the contract is '{contract}', "
                f"{key.others}; leave it out"
            )
