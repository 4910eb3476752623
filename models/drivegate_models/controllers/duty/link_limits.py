"""Currents within what the dc link takes: limits of the source's current, and of the link's voltage while braking.

While the link takes less than the braking shaft supplies, d-axis current burns the rest in the windings. Where even the
current limit does not burn enough, the braking torque gives way.
"""

from __future__ import annotations

from math import sqrt
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.duty.current_reference import torque_per_quadrature

_HALVINGS: Final = 24
# Control periods in which the braking power may charge the capacitor to its highest voltage: several times the answer
# of the currents.
_CHARGING_PERIODS: Final = 40.0
# Shares of the limits of the source's current that are used.
_SHARE_OF_CURRENT: Final = 0.97
# Parts of the energy of the greatest current in the windings that are reserved in the capacitor, which takes it when
# the current ends; and share of the link's limit that is used.
_RESERVED: Final = 2.0
_SHARE_OF_LIMIT: Final = 0.985


@inlined
def reset_link_limits(state: Any, nameplate: Any) -> None:
    """Write the constants of the link; a capacitance of 0 is an ideal link, which has no limits."""
    state.link_capacitance = nameplate.link_capacitance
    state.charge_limit = _SHARE_OF_CURRENT * nameplate.charge_limit
    state.discharge_limit = _SHARE_OF_CURRENT * nameplate.discharge_limit
    state.burning_power = 0.0
    state.highest_link = 0.0
    state.charging_gain = 0.0
    if nameplate.link_capacitance <= 0.0:
        return
    if nameplate.chopper_resistance > 0.0:
        state.burning_power = (
            nameplate.chopper_voltage * nameplate.chopper_voltage / nameplate.chopper_resistance
        )
    inductance = max(nameplate.direct_inductance, nameplate.quadrature_inductance)
    windings = 0.75 * inductance * nameplate.current_limit * nameplate.current_limit
    usable = _SHARE_OF_LIMIT * nameplate.link_limit
    reserved = 2.0 * _RESERVED * windings / nameplate.link_capacitance
    nominal = nameplate.supply_voltage
    # A small capacitor, which that energy alone would overcharge, still needs some power to brake.
    highest = max(usable * usable - reserved, 0.5 * (usable * usable + nominal * nominal))
    state.highest_link = sqrt(highest)
    state.charging_gain = 0.5 * nameplate.link_capacitance / (_CHARGING_PERIODS * nameplate.control_period)


@inlined
def _power(state: Any, electrical: float, direct: float, quadrature: float) -> float:
    """Return the power from the link for currents (W): of the shaft, copper and core."""
    shaft = torque_per_quadrature(state, direct) * quadrature * electrical / state.pole_pairs
    along = electrical * (state.direct_inductance * direct + state.magnet_flux)
    across = electrical * state.quadrature_inductance * quadrature
    square = direct * direct + quadrature * quadrature
    core = state.core_loss_conductance * (along * along + across * across)
    return float(shaft + 1.5 * (state.resistance * square + core))


@inlined
def _least_power(state: Any, voltage: float) -> float:
    """Return the least power from the link that source, chopper and capacitor allow at a voltage (W)."""
    headroom = state.charging_gain * (state.highest_link * state.highest_link - voltage * voltage)
    least = -(headroom + state.burning_power)
    if state.charge_limit > 0.0:
        least = max(
            least - voltage * state.charge_limit, -(voltage * state.charge_limit + state.burning_power)
        )
    return float(least)


@inlined
def _burning(
    state: Any, electrical: float, direct: float, quadrature: float, least: float
) -> tuple[float, float]:
    """Return currents that take at least a power (W), with the torque if the current limit allows it, or less of it."""
    limit = state.current_limit
    torque = torque_per_quadrature(state, direct) * quadrature
    # More d-axis current at the same torque, up to the current limit.
    inside, outside = 0.0, 1.0
    deepest = -sqrt(max(limit * limit - quadrature * quadrature, 0.0))
    kept = torque / torque_per_quadrature(state, deepest)
    if (
        abs(kept) <= abs(quadrature)
        and direct > deepest
        and _power(state, electrical, deepest, kept) >= least
    ):
        for _ in range(_HALVINGS):
            share = 0.5 * (inside + outside)
            burning = direct + share * (deepest - direct)
            needed = torque / torque_per_quadrature(state, burning)
            if _power(state, electrical, burning, needed) >= least:
                outside = share
            else:
                inside = share
        burning = direct + outside * (deepest - direct)
        return burning, torque / torque_per_quadrature(state, burning)
    # Less torque at the current limit.
    inside, outside = 0.0, 1.0
    for _ in range(_HALVINGS):
        share = 0.5 * (inside + outside)
        needed = share * quadrature
        if _power(state, electrical, -sqrt(limit * limit - needed * needed), needed) >= least:
            inside = share
        else:
            outside = share
    needed = inside * quadrature
    return -sqrt(limit * limit - needed * needed), needed


@inlined
def limited_by_link(
    state: Any, electrical: float, voltage: float, direct: float, quadrature: float
) -> tuple[float, float]:
    """Return d-axis and q-axis currents (A) whose power the link can supply or take.

    `electrical`: electrical speed (rad/s). `voltage`: present voltage of the link (V). `direct`, `quadrature`: currents
    for the requested torque (A). The result is the same if the link is ideal, or allows their power.
    """
    if state.link_capacitance <= 0.0:
        return direct, quadrature
    power = _power(state, electrical, direct, quadrature)
    most = voltage * state.discharge_limit
    if power > most > 0.0:
        inside, outside = 0.0, 1.0
        for _ in range(_HALVINGS):
            share = 0.5 * (inside + outside)
            if _power(state, electrical, direct, share * quadrature) <= most:
                inside = share
            else:
                outside = share
        return direct, inside * quadrature
    least = _least_power(state, voltage)
    if power < least:
        return _burning(state, electrical, direct, quadrature, least)
    return direct, quadrature
