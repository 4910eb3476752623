"""From torque to the currents of the rotor frame: most torque per ampere, and weakening where the voltage runs out."""

from __future__ import annotations

from math import sqrt
from typing import Any

from drivegate_models.compilation.kernels import inlined

_HALVINGS = 24
_GOLDEN = 0.6180339887498949


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
def _direct_for_torque(state: Any, torque: float) -> float:
    """Return the current along the magnet's axis that gives a torque with least current (A)."""
    low = 0.0
    high = state.current_limit
    for _ in range(_HALVINGS):
        current = 0.5 * (low + high)
        direct = most_torque_direct(state, current)
        quadrature = sqrt(max(current * current - direct * direct, 0.0))
        if torque_per_quadrature(state, direct) * quadrature < torque:
            low = current
        else:
            high = current
    return most_torque_direct(state, high)


@inlined
def _greatest_quadrature(state: Any, electrical: float, voltage: float, direct: float) -> float:
    """Return the greatest current across the magnet's axis within both limits (A); negative where there is none."""
    square = state.current_limit * state.current_limit - direct * direct
    if square < 0.0:
        return -1.0
    along = abs(electrical) * (state.direct_inductance * direct + state.magnet_flux)
    reactance = abs(electrical) * state.quadrature_inductance
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
    quadrature = _greatest_quadrature(state, electrical, voltage, direct)
    return torque_per_quadrature(state, direct) * quadrature


@inlined
def _direct_of_greatest_torque(state: Any, electrical: float, voltage: float) -> float:
    """Return the current along the magnet's axis at which the limits leave the greatest torque (A)."""
    # Further than the magnet's whole flux there is less torque for more current.
    low: float = max(-state.current_limit, -state.magnet_flux / state.direct_inductance)
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
def currents_for(state: Any, torque: float, electrical: float, voltage: float) -> tuple[float, float]:
    """Return the currents for a torque, or for as much of it as the limits allow.

    Parameters
    ----------
    state : record of FOC_STATE
        Constants of the machine, and the further weakening that the voltage has asked for.
    torque : float
        Wanted (N m).
    electrical : float
        Electrical speed (rad/s).
    voltage : float
        Peak voltage of a phase that may be used (V).

    Returns
    -------
    direct, quadrature : float
        (A).
    """
    wanted = abs(torque)
    deepest = _direct_of_greatest_torque(state, electrical, voltage)
    wanted = min(wanted, max(_greatest_torque_at(state, electrical, voltage, deepest), 0.0))
    direct = min(_direct_for_torque(state, wanted), 0.0)
    if _greatest_torque_at(state, electrical, voltage, direct) < wanted and deepest < direct:
        low = deepest
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + direct)
            if _greatest_torque_at(state, electrical, voltage, middle) < wanted:
                direct = middle
            else:
                low = middle
        direct = low
    direct = max(direct + state.weakening, -state.current_limit)
    room = sqrt(max(state.current_limit * state.current_limit - direct * direct, 0.0))
    quadrature = min(wanted / torque_per_quadrature(state, direct), room)
    return direct, quadrature if torque >= 0.0 else -quadrature
