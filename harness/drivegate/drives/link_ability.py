"""What the dc link of a PM AC drive allows over speed: power of the source, braking, and what a chopper has to burn."""

from __future__ import annotations

from math import isfinite
from typing import Any, Final

from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_models.pm_ac.link_oracle import (
    BRAKING,
    burnt_power,
    greatest_on_link,
    least_power,
    link_voltage,
    most_power,
)
from drivegate_models.pm_ac.plant.drive import PmAcDrive

_UNLIMITED_A: Final = 1e6


def braking_points(document: PmAcDocument, speed: float) -> dict[str, float | None]:
    """Return the greatest braking torques at a speed (rad/s) as keys of a point; none for an ideal link."""
    if document.real_link is None:
        return {}
    plant = document.plant()
    return {
        "braking_torque_nm": _braking(plant, speed),
        "burning_torque_nm": _braking(_taking(plant, 0.0), speed),
    }


def _taking(plant: PmAcDrive, charge_limit: float) -> PmAcDrive:
    """Return a drive without a chopper whose source takes a current back (A)."""
    return plant._replace(dc_link=plant.dc_link._replace(charge_limit=charge_limit, chopper_conductance=0.0))


def _braking(plant: PmAcDrive, speed: float) -> float | None:
    state = greatest_on_link(plant, plant.link_voltage, speed, plant.current_limit, BRAKING, True)
    return -state.torque if isfinite(state.torque) else None


def link_facts(document: PmAcDocument, speeds: list[float]) -> dict[str, Any]:
    """Return the powers and voltages of a link at speeds (rad/s), as plain data; empty for an ideal link."""
    link = document.real_link
    if link is None:
        return {}
    plant = document.plant()
    constants, nominal = plant.dc_link, plant.link_voltage
    most = most_power(constants, nominal)
    # A source that takes everything back shows what the shaft can supply.
    absorbing = _taking(plant, _UNLIMITED_A)._replace(link_voltage=nominal)
    regenerated = 0.0
    for speed in speeds:
        state = greatest_on_link(absorbing, nominal, speed, plant.current_limit, BRAKING, True)
        if isfinite(state.torque):
            regenerated = max(regenerated, -(state.torque * speed + state.copper_loss + state.core_loss))
    return {
        "source": link.source,
        "most_power_w": most,
        "loaded_voltage_v": link_voltage(constants, nominal, most),
        "taken_back_w": -least_power(constants, nominal) - burnt_power(constants),
        "burnt_w": burnt_power(constants),
        "regenerated_w": regenerated,
        "limit_v": constants.limit,
    }


def link_in_words(facts: dict[str, Any]) -> tuple[str, ...]:
    """Describe a link; nothing for an ideal one."""
    if not facts:
        return ()
    back = (
        f"takes back {facts['taken_back_w']:.4g} W" if facts["taken_back_w"] > 0.0 else "takes nothing back"
    )
    chopper = (
        f"the chopper burns {facts['burnt_w']:.4g} W" if facts["burnt_w"] > 0.0 else "there is no chopper"
    )
    return (
        f"link: the {facts['source']} supplies {facts['most_power_w']:.4g} W at {facts['loaded_voltage_v']:.4g} V and "
        f"{back}, {chopper}; braking at the current limit supplies up to {facts['regenerated_w']:.4g} W; limit "
        f"{facts['limit_v']:.4g} V",
    )
