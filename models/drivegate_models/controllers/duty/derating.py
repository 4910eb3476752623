"""Limit of the current by the temperature of the windings, which a model of their thermal node estimates."""

from __future__ import annotations

from math import isnan, sqrt
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.duty.current_reference import greatest_torque

# Time constant with which the temperature approaches its limit (s).
_APPROACH: Final = 0.3
# Both poles of the estimate's error are at half the inverse of the sensor's lag.
_CORRECTION: Final = 0.25
# Least current over the current limit, however hot the windings are.
_LEAST: Final = 0.01


@inlined
def reset_derating(state: Any, nameplate: Any) -> None:
    """Write the constants and reset everything else; the maximum torque at the whole current limit must be set."""
    state.full_current = nameplate.current_limit
    state.full_torque = state.greatest_torque
    state.is_derated = 0
    state.heat_capacity = nameplate.heat_capacity
    state.is_warm = 0
    if nameplate.heat_capacity <= 0.0:
        return
    state.heat_conductance = 1.0 / nameplate.thermal_resistance
    state.ambient_temperature = nameplate.ambient_temperature
    state.temperature_limit = nameplate.temperature_limit
    state.temperature_coefficient = nameplate.temperature_coefficient
    state.approach = _APPROACH
    lag, period = nameplate.temperature_lag, nameplate.control_period
    state.temperature_share = period / lag if lag > 0.0 else 0.0
    state.temperature_correction = _CORRECTION * state.temperature_share


@inlined
def _follow_temperature(state: Any, sensed: float, loss: float) -> None:
    """Estimate the temperature of the windings by their loss (W), corrected by the sensor (deg C), NaN without one."""
    if state.is_warm == 0:
        state.is_warm = 1
        state.winding_temperature = state.ambient_temperature if isnan(sensed) else sensed
        state.shown_temperature = state.winding_temperature
        return
    flow = (state.winding_temperature - state.ambient_temperature) * state.heat_conductance
    state.winding_temperature += state.control_period * (loss - flow) / state.heat_capacity
    if isnan(sensed):
        return
    if state.temperature_share == 0.0:
        state.winding_temperature = sensed
        return
    state.shown_temperature += state.temperature_share * (state.winding_temperature - state.shown_temperature)
    state.winding_temperature += state.temperature_correction * (sensed - state.shown_temperature)


@inlined
def derate(state: Any, sense: Any, direct: float, quadrature: float) -> None:
    """Limit the current to what brings the windings to their temperature limit without passing it.

    `direct`, `quadrature`: currents at the start of the period (A). The permitted loss is what flows to the
    surroundings, and what heats the windings by their distance from the limit in a fixed time. The limit is that of the
    whole current: field weakening comes first, and the torque has the rest.
    """
    if state.heat_capacity <= 0.0:
        return
    above = state.winding_temperature - state.ambient_temperature
    whole = 1.5 * state.resistance * (1.0 + state.temperature_coefficient * above)
    _follow_temperature(state, sense.winding_temperature, whole * (direct * direct + quadrature * quadrature))
    left = state.heat_capacity * (state.temperature_limit - state.winding_temperature) / state.approach
    flow = (state.winding_temperature - state.ambient_temperature) * state.heat_conductance
    permitted = max(flow + left, 0.0)
    if permitted >= whole * state.full_current * state.full_current:
        if state.is_derated == 1:
            state.is_derated = 0
            state.current_limit, state.greatest_torque = state.full_current, state.full_torque
        return
    state.is_derated = 1
    state.current_limit = max(sqrt(permitted / whole), _LEAST * state.full_current)
    state.greatest_torque = greatest_torque(state)
