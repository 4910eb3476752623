"""Currents of the rotor frame for a torque: maximum torque per ampere, and field weakening at the voltage limit."""

from __future__ import annotations

from math import isnan, nan, sqrt
from typing import Any

from drivegate_models.compilation.kernels import inlined

_HALVINGS = 24
_NEWTON_STEPS = 16
_CONVERGED = 1e-9
# Newton's relative step below which it is the last one: the remaining error is at most 1.5 times its square, 6e-10.
_LAST_STEP = 2e-5
# The last root is not a better initial value below this share of a bound above the root.
_FAR_BELOW = 0.125
_GOLDEN = 0.6180339887498949
# Electrical speed that counts as standstill (rad/s).
_STANDSTILL = 1e-9


@inlined
def torque_per_quadrature(state: Any, direct: float) -> float:
    """Return the torque per ampere of q-axis current (N m/A), at a d-axis current (A)."""
    saliency = state.direct_inductance - state.quadrature_inductance
    return float(1.5 * state.pole_pairs * (state.magnet_flux + saliency * direct))


@inlined
def maximum_torque_direct(state: Any, current: float) -> float:
    """Return the d-axis current of maximum torque at a current magnitude (both A)."""
    saliency = state.quadrature_inductance - state.direct_inductance
    square = current * current
    root = sqrt(state.magnet_flux * state.magnet_flux + 8.0 * saliency * saliency * square)
    return float(-2.0 * saliency * square / (state.magnet_flux + root))


@inlined
def greatest_torque(state: Any) -> float:
    """Return the torque at the current limit, without a voltage limit (N m)."""
    direct = maximum_torque_direct(state, state.current_limit)
    return torque_per_quadrature(state, direct) * sqrt(
        state.current_limit * state.current_limit - direct * direct
    )


@inlined
def _initial_flux(state: Any, square: float) -> float:
    """Return the initial value for the root y of ``y (psi + y)**3 = square``: usually the last result."""
    last = state.added_flux
    cube = state.magnet_flux * state.magnet_flux * state.magnet_flux
    if square < cube * state.magnet_flux:
        # From one step to the next the torque changes little. This test avoids a division, because every step runs it.
        near = cube * last
        return float(last if _FAR_BELOW * square < near < square else square / cube)
    above = sqrt(sqrt(square))
    return float(last if _FAR_BELOW * above < last < above else above)


@inlined
def least_current_direct(state: Any, torque: float) -> float:
    """Return the d-axis current (A) that provides a torque (N m) with minimum current, limited to field weakening.

    With ``D = L_d - L_q`` the flux ``psi + y`` that makes the torque is ``psi + D i_d``, and along the MTPA line
    ``D**2 i_q**2 = y (psi + y)``. Hence ``y (psi + y)**3 = (D T / k)**2``, where k is 1.5 times the pole pairs. The
    left side is convex, so Newton's method descends to the root from any value above it, and reaches that side in
    one step from any value below. It starts from the last result if that is close.
    """
    flux = state.magnet_flux
    saliency = state.direct_inductance - state.quadrature_inductance
    reach = saliency * torque / (1.5 * state.pole_pairs)
    square = reach * reach
    if square <= 0.0:
        return 0.0
    added = _initial_flux(state, square)
    for _ in range(_NEWTON_STEPS):
        whole = flux + added
        step = (added * whole * whole * whole - square) / (whole * whole * (whole + 3.0 * added))
        added -= step
        if abs(step) <= _LAST_STEP * added:
            break
    state.added_flux = added
    return float(min(added / saliency, 0.0))


@inlined
def _maximum_quadrature(
    state: Any, electrical: float, voltage: float, resistance: float, direct: float
) -> float:
    """Return the maximum q-axis current within the limits of current and voltage (V), negative if there is none (A)."""
    square = state.current_limit * state.current_limit - direct * direct
    if square < 0.0:
        return -1.0
    along = electrical * (state.direct_inductance * direct + state.magnet_flux)
    reactance = electrical * state.quadrature_inductance
    # |v| = V is a quadratic in this current: a q**2 + 2 b q + c = 0.
    a = reactance * reactance + resistance * resistance
    b = resistance * along - reactance * resistance * direct
    c = resistance * resistance * direct * direct + along * along - voltage * voltage
    inside = b * b - a * c
    if inside < 0.0:
        return -1.0
    return float(min(sqrt(square), (sqrt(inside) - b) / a))


@inlined
def _maximum_torque_at(
    state: Any, electrical: float, voltage: float, resistance: float, direct: float
) -> float:
    """Return the maximum torque within both limits at a d-axis current (A), -1 if there is none (N m)."""
    quadrature = _maximum_quadrature(state, electrical, voltage, resistance, direct)
    return torque_per_quadrature(state, direct) * quadrature if quadrature >= 0.0 else -1.0


@inlined
def _direct_at_maximum_torque_per_volt(state: Any, electrical: float, voltage: float) -> float:
    """Return the d-axis current (A) of maximum torque per volt (MTPV), neglecting resistance.

    With the voltage's flux ``F = V / w`` the torque is proportional to ``(L_q psi - s x) sqrt(F**2 - x**2)``, where
    x is the d-axis flux and s = L_q - L_d. It is maximal at the lower root of ``2 s x**2 - L_q psi x - s F**2 =
    0``: a salient machine is weakened beyond the magnet's whole flux.
    """
    flux = state.quadrature_inductance * state.magnet_flux
    saliency = state.quadrature_inductance - state.direct_inductance
    greatest = voltage / max(electrical, _STANDSTILL)
    beyond = sqrt(flux * flux + 8.0 * saliency * saliency * greatest * greatest)
    beyond = 2.0 * saliency * greatest * greatest / (flux + beyond)
    return float(-(state.magnet_flux + beyond) / state.direct_inductance)


@inlined
def _direct_at_maximum_torque(state: Any, electrical: float, voltage: float, resistance: float) -> float:
    """Return the d-axis current (A) at which the limits allow the maximum torque."""
    low: float = max(state.deepest, _direct_at_maximum_torque_per_volt(state, electrical, voltage))
    high = maximum_torque_direct(state, state.current_limit)
    if low >= high:
        return high
    for _ in range(_HALVINGS):
        inner = high - _GOLDEN * (high - low)
        outer = low + _GOLDEN * (high - low)
        at_inner = _maximum_torque_at(state, electrical, voltage, resistance, inner)
        at_outer = _maximum_torque_at(state, electrical, voltage, resistance, outer)
        # If both are infeasible, more weakening leads to a feasible current.
        if at_inner >= at_outer and (at_inner >= 0.0 or at_outer < 0.0):
            high = outer
        else:
            low = inner
    return 0.5 * (low + high)


@inlined
def _weakened_direct(
    state: Any, torque: float, electrical: float, voltage: float, resistance: float, direct: float
) -> float:
    """Return the d-axis current (A) at which a torque (N m) needs no more than a voltage (V).

    With the q-axis current that produces the torque, the square of the voltage is convex in the d-axis current.
    Newton's method therefore descends to the first root from the side of too much voltage. NaN if there is none
    within the limit.
    """
    saliency = state.direct_inductance - state.quadrature_inductance
    slack = _CONVERGED * voltage * voltage
    for _ in range(_NEWTON_STEPS):
        per_ampere = torque_per_quadrature(state, direct)
        quadrature = torque / per_ampere
        along = resistance * direct - electrical * state.quadrature_inductance * quadrature
        across = resistance * quadrature + electrical * (state.direct_inductance * direct + state.magnet_flux)
        excess = along * along + across * across - voltage * voltage
        if excess <= slack:
            square = direct * direct + quadrature * quadrature
            inside = square <= (1.0 + _CONVERGED) * state.current_limit * state.current_limit
            return direct if inside else nan
        change = -1.5 * state.pole_pairs * saliency * quadrature / per_ampere
        slope = 2.0 * along * (resistance - electrical * state.quadrature_inductance * change)
        slope += 2.0 * across * (resistance * change + electrical * state.direct_inductance)
        if slope <= 0.0:
            return nan
        direct -= excess / slope
        if direct < -state.current_limit:
            return nan
    return nan


@inlined
def limited_by_voltage(
    state: Any, torque: float, electrical: float, voltage: float, resistance: float, direct: float
) -> tuple[float, float]:
    """Return the d-axis current (A) weakened as far as a torque requires, and the torque (N m).

    `torque` is the requested torque (N m, at least 0), `electrical` the electrical speed (rad/s), `voltage` the
    allowed peak phase voltage (V), `resistance` that of the machine (ohm), negative for a braking torque, and
    `direct` the d-axis current without a voltage limit (A). The returned torque is smaller if the limits do not
    allow all of it. Braking mirrors the q axis, and with it the sign of the voltage across the resistance alone.
    """
    absolute_speed = abs(electrical)
    weakened = _weakened_direct(state, torque, absolute_speed, voltage, resistance, direct)
    if isnan(weakened):
        # With less weakening than intended, the current may suffice.
        weakened = _weakened_direct(
            state, torque, absolute_speed, voltage, resistance, least_current_direct(state, torque)
        )
    if isnan(weakened):
        weakened = _direct_at_maximum_torque(state, absolute_speed, voltage, resistance)
        torque = min(
            torque, max(_maximum_torque_at(state, absolute_speed, voltage, resistance, weakened), 0.0)
        )
    return weakened, torque


@inlined
def currents_for_torque(state: Any, direct: float, torque: float, is_backward: bool) -> tuple[float, float]:
    """Return the d-axis and q-axis currents (A) for a torque (N m), within the current limit."""
    direct = max(direct, state.deepest)
    headroom = sqrt(max(state.current_limit * state.current_limit - direct * direct, 0.0))
    quadrature = min(torque / torque_per_quadrature(state, direct), headroom)
    return direct, -quadrature if is_backward else quadrature
