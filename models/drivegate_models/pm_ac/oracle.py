"""The best operation of a PM AC drive at a speed: minimum current, minimum loss and maximum torque within its limits.

The currents for a torque are a curve over the d-axis current. The curve is searched densely between the ends allowed by
the limits, and then by golden section. There is no assumption on its number of valleys.
"""

from __future__ import annotations

from math import inf, sqrt
from typing import Final, NamedTuple

from drivegate_models.compilation.kernels import inlined, kernel
from drivegate_models.pm_ac.fundamental import (
    LINEAR_LIMIT,
    SteadyState,
    base_speed,
    core_loss,
    steady_state,
    steady_voltages,
)
from drivegate_models.pm_ac.plant.drive import PmAcDrive, electrical_torque

CURRENT: Final = 0
"""Minimize the current."""
LOSS: Final = 1
"""Minimize the sum of copper and core loss."""

_PLACES = 2000
_GOLDEN = 0.6180339887498949
_NARROWINGS = 60
_HALVINGS = 100
_SLACK = 1e-12
_FURTHEST = 1e6
"""Multiple of base speed beyond which constant power counts as unlimited (1)."""


class Limits(NamedTuple):
    """Limits of current and voltage in a search."""

    current: float
    """Maximum peak current of a phase (A)."""
    voltage: float
    """Maximum peak voltage of a phase (V)."""


def undistorted_limits(drive: PmAcDrive, link: float | None = None) -> Limits:
    """Return a drive's current limit and the linear modulation limit of a link voltage.

    While the machine drives, current flows through two switches from one rail to the other, which take their drops.

    `link`: voltage of the link (V); the drive's nominal one by default.
    """
    whole = drive.link_voltage if link is None else link
    return Limits(drive.current_limit, LINEAR_LIMIT * max(whole - 2.0 * drive.switch_drop, 0.0))


@inlined
def _no_state() -> SteadyState:
    """Return the result if no currents are feasible, with NaN for all values."""
    nothing = inf - inf
    return SteadyState(nothing, nothing, nothing, nothing, nothing, nothing, nothing)


@inlined
def _is_within(drive: PmAcDrive, limits: Limits, electrical: float, direct: float, quadrature: float) -> bool:
    """Return True if currents are within both limits, except for rounding."""
    along, across = steady_voltages(drive, electrical, direct, quadrature)
    slack = 1.0 + _SLACK
    return (
        direct * direct + quadrature * quadrature <= limits.current * limits.current * slack
        and along * along + across * across <= limits.voltage * limits.voltage * slack
    )


@inlined
def _direct_range(drive: PmAcDrive, limits: Limits, electrical: float) -> tuple[float, float]:
    """Return the minimum and maximum d-axis current within both limits (A); reversed if there is none."""
    reactance = electrical * drive.quadrature_inductance
    resistance = drive.resistance
    determinant = resistance * resistance + electrical * drive.direct_inductance * reactance
    if determinant == 0.0:
        return -limits.current, limits.current
    centre = -reactance * electrical * drive.magnet_flux / determinant
    reach = limits.voltage * sqrt(resistance * resistance + reactance * reactance) / determinant
    return max(-limits.current, centre - reach), min(limits.current, centre + reach)


@inlined
def _quadrature_of(drive: PmAcDrive, torque: float, direct: float) -> float:
    """Return the q-axis current for a torque (A); infinite if there is none."""
    per_ampere = electrical_torque(drive, direct, 1.0)
    if per_ampere == 0.0:
        return 0.0 if torque == 0.0 else inf
    return torque / per_ampere


@inlined
def _cost(
    drive: PmAcDrive, limits: Limits, electrical: float, torque: float, purpose: int, direct: float
) -> float:
    """Return the cost of a d-axis current, in the unit of the purpose (A2 or W); infinite beyond the limits."""
    quadrature = _quadrature_of(drive, torque, direct)
    if quadrature == inf or not _is_within(drive, limits, electrical, direct, quadrature):
        return inf
    square = direct * direct + quadrature * quadrature
    if purpose == CURRENT:
        return square
    return 1.5 * drive.resistance * square + core_loss(drive, electrical, direct, quadrature)


@inlined
def _feasible_end(
    drive: PmAcDrive,
    limits: Limits,
    electrical: float,
    torque: float,
    inside: float,
    outside: float,
) -> float:
    """Return the last feasible d-axis current between a feasible and an infeasible one (A)."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (inside + outside)
        if middle in (inside, outside):
            break
        if _cost(drive, limits, electrical, torque, CURRENT, middle) < inf:
            inside = middle
        else:
            outside = middle
    return inside


@kernel
def least_at(drive: PmAcDrive, limits: Limits, speed: float, torque: float, purpose: int) -> SteadyState:
    """Return the steady state of minimum current or minimum loss for a torque at a speed.

    `speed`: shaft speed (rad/s). `torque`: electromagnetic torque (N m). `purpose`: `CURRENT` or `LOSS`. Result: all
    NaN if no currents within the limits produce that torque.
    """
    electrical = drive.pole_pairs * speed
    first, last = _direct_range(drive, limits, electrical)
    step = max(last - first, 0.0) / _PLACES
    best = inf
    best_direct = 0.0
    for k in range(_PLACES + 1):
        direct = first + k * step
        cost = _cost(drive, limits, electrical, torque, purpose, direct)
        if cost < best:
            best = cost
            best_direct = direct
    if best == inf:
        # A narrow range of feasible currents between two grid points exists only close to the maximum torque.
        top = greatest_torque(drive, limits, speed)
        if not top.torque >= torque * (1.0 - _SLACK) or torque < 0.0:
            return _no_state()
        best_direct = top.direct
        if _cost(drive, limits, electrical, torque, purpose, best_direct) == inf:
            return top
    low = _feasible_end(drive, limits, electrical, torque, best_direct, best_direct - step)
    high = _feasible_end(drive, limits, electrical, torque, best_direct, best_direct + step)
    inner = high - _GOLDEN * (high - low)
    outer = low + _GOLDEN * (high - low)
    inner_cost = _cost(drive, limits, electrical, torque, purpose, inner)
    outer_cost = _cost(drive, limits, electrical, torque, purpose, outer)
    for _ in range(_NARROWINGS):
        if inner_cost <= outer_cost:
            high, outer, outer_cost = outer, inner, inner_cost
            inner = high - _GOLDEN * (high - low)
            inner_cost = _cost(drive, limits, electrical, torque, purpose, inner)
        else:
            low, inner, inner_cost = inner, outer, outer_cost
            outer = low + _GOLDEN * (high - low)
            outer_cost = _cost(drive, limits, electrical, torque, purpose, outer)
    found = best_direct
    least = _cost(drive, limits, electrical, torque, purpose, found)
    for place in (low, 0.5 * (low + high), high):
        cost = _cost(drive, limits, electrical, torque, purpose, place)
        if cost < least:
            least = cost
            found = place
    return steady_state(drive, speed, found, _quadrature_of(drive, torque, found))


@inlined
def _greatest_at(drive: PmAcDrive, limits: Limits, electrical: float, direct: float) -> tuple[float, float]:
    """Return the maximum torque at a d-axis current (N m), and its q-axis current (A); -inf if there is none."""
    square = limits.current * limits.current - direct * direct
    if square < 0.0:
        return -inf, 0.0
    high = sqrt(square)
    low = -high
    # The voltage limit is quadratic in the q-axis current: a q**2 + 2 b q + c <= 0.
    along = electrical * (drive.direct_inductance * direct + drive.magnet_flux)
    reactance = electrical * drive.quadrature_inductance
    resistance = drive.resistance
    a = reactance * reactance + resistance * resistance
    b = resistance * along - reactance * resistance * direct
    c = resistance * resistance * direct * direct + along * along - limits.voltage * limits.voltage
    if a > 0.0:
        inside = b * b - a * c
        if inside < 0.0:
            return -inf, 0.0
        root = sqrt(inside)
        high = min(high, (root - b) / a)
        low = max(low, -(root + b) / a)
    elif c > 0.0:
        return -inf, 0.0
    if low > high:
        return -inf, 0.0
    above = electrical_torque(drive, direct, high)
    below = electrical_torque(drive, direct, low)
    return (above, high) if above >= below else (below, low)


@kernel
def greatest_torque(drive: PmAcDrive, limits: Limits, speed: float) -> SteadyState:
    """Return the steady state of maximum torque at a speed.

    `speed`: shaft speed (rad/s). Result: all NaN if no currents are within both limits.
    """
    electrical = drive.pole_pairs * speed
    first, last = _direct_range(drive, limits, electrical)
    step = max(last - first, 0.0) / _PLACES
    best = -inf
    best_direct = 0.0
    for k in range(_PLACES + 1):
        direct = first + k * step
        torque = _greatest_at(drive, limits, electrical, direct)[0]
        if torque > best:
            best = torque
            best_direct = direct
    if best == -inf:
        return _no_state()
    low = max(best_direct - step, first)
    high = min(best_direct + step, last)
    for _ in range(_NARROWINGS):
        inner = high - _GOLDEN * (high - low)
        outer = low + _GOLDEN * (high - low)
        if (
            _greatest_at(drive, limits, electrical, inner)[0]
            >= _greatest_at(drive, limits, electrical, outer)[0]
        ):
            high = outer
        else:
            low = inner
    for place in (low, 0.5 * (low + high), high):
        torque = _greatest_at(drive, limits, electrical, place)[0]
        if torque > best:
            best = torque
            best_direct = place
    return steady_state(drive, speed, best_direct, _greatest_at(drive, limits, electrical, best_direct)[1])


@kernel
def constant_power_end(drive: PmAcDrive, limits: Limits, power: float) -> float:
    """Return the maximum speed up to which a mechanical power can be maintained, beginning at base speed.

    `power`: electromagnetic torque times speed (W). Result: shaft speed (rad/s), 0 if the power is not reached at base
    speed. It is infinite if the power is maintained beyond a million times base speed, as with a current limit that
    can cancel the magnet's flux (psi/L_d <= I) and a power that is small enough.
    """
    begin = base_speed(drive, limits.current, limits.voltage)
    if begin == 0.0 or not greatest_torque(drive, limits, begin).torque * begin >= power * (1.0 - _SLACK):
        return 0.0
    inside = begin
    outside = begin
    while outside < _FURTHEST * begin:
        outside *= 1.1
        if not greatest_torque(drive, limits, outside).torque * outside >= power:
            break
        inside = outside
    if inside == outside:
        return inf
    for _ in range(_HALVINGS):
        middle = 0.5 * (inside + outside)
        if middle in (inside, outside):
            break
        if greatest_torque(drive, limits, middle).torque * middle >= power:
            inside = middle
        else:
            outside = middle
    return inside
