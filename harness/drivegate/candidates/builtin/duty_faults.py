"""Faulty controllers of duty ratios: field-oriented control with other constants, and the checks that catch them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

STUCK_SHARE: Final = 0.3
"""Weakening that stays on, over the current limit (1)."""


@dataclass(frozen=True)
class DutyFault:
    """A fault that is made by changing the state after a reset.

    Attributes
    ----------
    check : str
        Check that must catch it.
    sentence : str
        What the controller does wrong.
    alter : callable
        Changes the record of the state, just reset.
    """

    check: str
    sentence: str
    alter: Callable[[Any], None]


def _stuck(state: Any) -> None:
    state["weakening"] = -STUCK_SHARE * state["current_limit"]
    state["weakening_step"] = 0.0


def _scaled(factor: float, *fields: str) -> Callable[[Any], None]:
    def alter(state: Any) -> None:
        for field in fields:
            state[field] *= factor

    return alter


def _without_saliency(state: Any) -> None:
    state["quadrature_inductance"] = state["direct_inductance"]


def _another_pole_pair(state: Any) -> None:
    state["pole_pairs"] += 1.0


DUTY_FAULTS: Final = {
    "stuck-weakening": DutyFault(
        "FWK-2",
        "Weakens by 30 % of the current limit at all times, whatever the voltage, also at standstill without torque.",
        _stuck,
    ),
    "delay-not-compensated": DutyFault(
        "FWK-3",
        "Turns its voltages by the angle of the sample, not by that at which they act.",
        _scaled(0.0, "lead"),
    ),
    "wrong-pole-pairs": DutyFault("ACC-1", "Counts one pole pair too many.", _another_pole_pair),
    "generous-current-limit": DutyFault(
        "OVC-1", "Takes a current limit that is 40 % too high.", _scaled(1.4, "current_limit")
    ),
    "weak-magnets-assumed": DutyFault(
        "ACC-1", "Converts torque to current with 80 % of the magnet's flux.", _scaled(0.8, "magnet_flux")
    ),
    "saliency-ignored": DutyFault(
        "MTP-1", "Takes the inductance of the magnet's axis for both axes.", _without_saliency
    ),
    "no-speed-integral": DutyFault(
        "ACC-1", "Regulates the speed by its error alone.", _scaled(0.0, "speed_integral_step")
    ),
    "slow-currents": DutyFault(
        "STP-1",
        "Regulates its currents with a sixth of the gain.",
        _scaled(
            1.0 / 6.0, "direct_gain", "quadrature_gain", "direct_integral_step", "quadrature_integral_step"
        ),
    ),
    "nervous-currents": DutyFault(
        "STP-1",
        "Regulates its currents with three times the gain.",
        _scaled(3.0, "direct_gain", "quadrature_gain"),
    ),
}
"""All of them, by the name behind ``faulty:``."""
