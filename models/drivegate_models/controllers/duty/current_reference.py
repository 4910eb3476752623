"""From torque to the currents of the rotor frame: most torque per ampere, and weakening where the voltage runs out."""

from __future__ import annotations

from math import isnan, nan, sqrt
from typing import Any

from drivegate_models.compilation.kernels import inlined

_HALVINGS = 24
_NEWTON_STEPS = 16
_CONVERGED = 1e-9
# Newton's step over the root from which on it is the last one: it leaves three halves of its square at most, 6e-10.
_LAST_STEP = 2e-5
# Share of a place above the root below which the last root is no better place to begin.
_FAR_BELOW = 0.125
_GOLDEN = 0.6180339887498949
# Electrical speed that is as good as none (rad/s).
_STANDSTILL = 1e-9


@inlined
def torque_per_quadrature(state: Any, direct: float) -> float:
    """Return the torque of an ampere across the magnet's axis, at a current along it (N m/A)."""
    saliency = state.direct_inductance - state.quadrature_inductance
    return float(1.5 * state.pole_pairs * (state.magnet_flux + saliency * direct))


@inlined
def most_torque_direct(state: Any, current: float) -> float:
    """Return the current along the magnet's axis that gives most torque at a magnitude (A)."""
    saliency = state.quadrature_inductance - state.direct_inductance
    square = current * current
    root = sqrt(state.magnet_flux * state.magnet_flux + 8.0 * saliency * saliency * square)
    return float(-2.0 * saliency * square / (state.magnet_flux + root))


@inlined
def _beginning(state: Any, square: float) -> float:
    """Return where to begin to look for the root y of ``y (psi + y)**3``: mostly where the last search has ended."""
    last = state.added_flux
    cube = state.magnet_flux * state.magnet_flux * state.magnet_flux
    if square < cube * state.magnet_flux:
        # From one step to the next the torque changes little. Without a division, since it is asked in each.
        near = cube * last
        return float(last if _FAR_BELOW * square < near < square else square / cube)
    above = sqrt(sqrt(square))
    return float(last if _FAR_BELOW * above < last < above else above)


@inlined
def least_current_direct(state: Any, torque: float) -> float:
    """Return the current along the magnet's axis that gives a torque with least current, if it weakens (A).

    Notes
    -----
    With ``D = L_d - L_q`` the flux ``psi + y`` that makes the torque is ``psi + D i_d``, and along the line of most
    torque per ampere ``D**2 i_q**2 = y (psi + y)``; so ``y (psi + y)**3 = (D T / k)**2``, where k is three halves of
    the pole pairs. The left side is convex, so Newton's method comes down to the root from any place above it, and
    gets there by one step from any below it. It begins where it has ended the time before, if that is not far off.
    """
    flux = state.magnet_flux
    saliency = state.direct_inductance - state.quadrature_inductance
    reach = saliency * torque / (1.5 * state.pole_pairs)
    square = reach * reach
    if square <= 0.0:
        return 0.0
    added = _beginning(state, square)
    for _ in range(_NEWTON_STEPS):
        whole = flux + added
        step = (added * whole * whole * whole - square) / (whole * whole * (whole + 3.0 * added))
        added -= step
        if abs(step) <= _LAST_STEP * added:
            break
    state.added_flux = added
    return float(min(added / saliency, 0.0))


@inlined
def _greatest_quadrature(state: Any, electrical: float, voltage: float, direct: float) -> float:
    """Return the greatest current across the magnet's axis within both limits (A); negative where there is none."""
    square = state.current_limit * state.current_limit - direct * direct
    if square < 0.0:
        return -1.0
    along = electrical * (state.direct_inductance * direct + state.magnet_flux)
    reactance = electrical * state.quadrature_inductance
    resistance = state.resistance
    # |v| = V is a quadratic in this current: a q**2 + 2 b q + c = 0.
    a = reactance * reactance + resistance * resistance
    b = resistance * along - reactance * resistance * direct
    c = resistance * resistance * direct * direct + along * along - voltage * voltage
    inside = b * b - a * c
    if inside < 0.0:
        return -1.0
    return float(min(sqrt(square), (sqrt(inside) - b) / a))


@inlined
def _greatest_torque_at(state: Any, electrical: float, voltage: float, direct: float) -> float:
    """Return the greatest torque within both limits at a current along the magnet's axis (N m), -1 for none."""
    quadrature = _greatest_quadrature(state, electrical, voltage, direct)
    return torque_per_quadrature(state, direct) * quadrature if quadrature >= 0.0 else -1.0


@inlined
def _direct_of_most_torque_per_volt(state: Any, electrical: float, voltage: float) -> float:
    """Return the current along the magnet's axis that gives most torque at a voltage, without resistance (A).

    Notes
    -----
    With the voltage's flux ``F = V / w`` the torque goes with ``(L_q psi - s x) sqrt(F**2 - x**2)``, where x is the
    flux along the magnet's axis and s = L_q - L_d. It is greatest at the lower root of
    ``2 s x**2 - L_q psi x - s F**2 = 0``: a salient machine is weakened beyond the magnet's whole flux.
    """
    flux = state.quadrature_inductance * state.magnet_flux
    saliency = state.quadrature_inductance - state.direct_inductance
    greatest = voltage / max(electrical, _STANDSTILL)
    beyond = sqrt(flux * flux + 8.0 * saliency * saliency * greatest * greatest)
    beyond = 2.0 * saliency * greatest * greatest / (flux + beyond)
    return float(-(state.magnet_flux + beyond) / state.direct_inductance)


@inlined
def _direct_of_greatest_torque(state: Any, electrical: float, voltage: float) -> float:
    """Return the current along the magnet's axis at which the limits leave the greatest torque (A)."""
    low: float = max(state.deepest, _direct_of_most_torque_per_volt(state, electrical, voltage))
    high = most_torque_direct(state, state.current_limit)
    if low >= high:
        return high
    for _ in range(_HALVINGS):
        inner = high - _GOLDEN * (high - low)
        outer = low + _GOLDEN * (high - low)
        at_inner = _greatest_torque_at(state, electrical, voltage, inner)
        at_outer = _greatest_torque_at(state, electrical, voltage, outer)
        # Where neither can be had at all, more weakening leads to where something can.
        if at_inner >= at_outer and (at_inner >= 0.0 or at_outer < 0.0):
            high = outer
        else:
            low = inner
    return 0.5 * (low + high)


@inlined
def _weakened_direct(state: Any, torque: float, electrical: float, voltage: float, direct: float) -> float:
    """Return the current along the magnet's axis from which on a torque needs no more than a voltage (A).

    With the current across that makes the torque, the square of the voltage is convex in that along, so Newton's
    method comes down to the first root from the side of too much voltage; NaN where there is none within the limit.
    """
    saliency = state.direct_inductance - state.quadrature_inductance
    slack = _CONVERGED * voltage * voltage
    for _ in range(_NEWTON_STEPS):
        per_ampere = torque_per_quadrature(state, direct)
        quadrature = torque / per_ampere
        along = state.resistance * direct - electrical * state.quadrature_inductance * quadrature
        across = state.resistance * quadrature + electrical * (
            state.direct_inductance * direct + state.magnet_flux
        )
        excess = along * along + across * across - voltage * voltage
        if excess <= slack:
            square = direct * direct + quadrature * quadrature
            inside = square <= (1.0 + _CONVERGED) * state.current_limit * state.current_limit
            return direct if inside else nan
        change = -1.5 * state.pole_pairs * saliency * quadrature / per_ampere
        slope = 2.0 * along * (state.resistance - electrical * state.quadrature_inductance * change)
        slope += 2.0 * across * (state.resistance * change + electrical * state.direct_inductance)
        if slope <= 0.0:
            return nan
        direct -= excess / slope
        if direct < -state.current_limit:
            return nan
    return nan


@inlined
def within_voltage(
    state: Any, torque: float, electrical: float, voltage: float, direct: float
) -> tuple[float, float]:
    """Weaken the field as far as a torque needs it.

    Parameters
    ----------
    torque : float
        Wanted, at least 0 (N m).
    electrical : float
        Electrical speed (rad/s).
    voltage : float
        Peak voltage of a phase that may be used (V).
    direct : float
        Current along the magnet's axis if the voltage were free (A).

    Returns
    -------
    direct, torque : float
        (A, N m); less torque where the limits leave less.
    """
    turning = abs(electrical)
    weakened = _weakened_direct(state, torque, turning, voltage, direct)
    if isnan(weakened):
        # With less weakening than was aimed at, the current may do.
        weakened = _weakened_direct(state, torque, turning, voltage, least_current_direct(state, torque))
    if isnan(weakened):
        weakened = _direct_of_greatest_torque(state, turning, voltage)
        torque = min(torque, max(_greatest_torque_at(state, turning, voltage, weakened), 0.0))
    return weakened, torque


@inlined
def with_torque(state: Any, direct: float, torque: float, is_backward: bool) -> tuple[float, float]:
    """Return the currents of a torque (N m) at one along the magnet's axis (A), within the current limit."""
    direct = max(direct, state.deepest)
    room = sqrt(max(state.current_limit * state.current_limit - direct * direct, 0.0))
    quadrature = min(torque / torque_per_quadrature(state, direct), room)
    return direct, -quadrature if is_backward else quadrature
