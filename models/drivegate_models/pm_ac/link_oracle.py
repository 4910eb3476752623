"""The greatest driving and braking torque of a PM AC drive whose dc link is not ideal.

The link's voltage follows from the power that the drive takes, and limits of the source from its current. While a
source takes nothing back, a shaft is braked by what windings, core and chopper burn, with d-axis current where that
helps.
"""

from __future__ import annotations

from math import inf, sqrt
from typing import Final

from drivegate_models.compilation.kernels import inlined, kernel
from drivegate_models.pm_ac.fundamental import (
    LINEAR_LIMIT,
    SteadyState,
    core_loss,
    most_torque_per_ampere,
    steady_state,
    steady_voltages,
)
from drivegate_models.pm_ac.plant.dc_link import BATTERY, DcLink
from drivegate_models.pm_ac.plant.drive import PmAcDrive, electrical_torque

DRIVING: Final = 1.0
BRAKING: Final = -1.0

_PLACES: Final = 120
_SCANNED: Final = 64
_HALVINGS: Final = 50
_NARROWINGS: Final = 40
_GOLDEN: Final = 0.6180339887498949
_SLACK: Final = 1e-12


@inlined
def most_power(link: DcLink, source: float) -> float:
    """Return the greatest power that a source (V) supplies to the link within its limit of current (W)."""
    current = min(link.discharge_limit, 0.5 * source / link.source_resistance)
    return (source - link.source_resistance * current) * current


@inlined
def burnt_power(link: DcLink) -> float:
    """Return the power of the chopper at the voltage at which it turns on by itself (W)."""
    return link.chopper_conductance * link.chopper_on * link.chopper_on


@inlined
def least_power(link: DcLink, source: float) -> float:
    """Return the least power from the link in a steady state (W): what source (V) and chopper take back, negative."""
    charging = (source + link.source_resistance * link.charge_limit) * link.charge_limit
    return -(charging + burnt_power(link))


@inlined
def link_voltage(link: DcLink, source: float, power: float) -> float:
    """Return the mean voltage of the link in a steady state (V), 0 if the source (V) does not supply the power (W).

    It is the upper root of ``v (E - v) / R = P``. A source that takes nothing back leaves the link to the chopper,
    whose lower threshold counts.
    """
    if power < 0.0 and link.source != BATTERY:
        return link.chopper_off if link.chopper_conductance > 0.0 else source
    inside = source * source - 4.0 * link.source_resistance * power
    return 0.5 * (source + sqrt(inside)) if inside >= 0.0 else 0.0


@inlined
def power_of(drive: PmAcDrive, electrical: float, direct: float, quadrature: float) -> float:
    """Return the power from the link for steady currents (A): shaft, copper and core (W)."""
    along, across = steady_voltages(drive, electrical, direct, quadrature)
    return 1.5 * (along * direct + across * quadrature) + core_loss(drive, electrical, direct, quadrature)


@inlined
def _is_within(
    drive: PmAcDrive, source: float, electrical: float, direct: float, quadrature: float, current: float
) -> bool:
    """Return True if currents are within the limits of current, voltage and source, except for rounding."""
    slack = 1.0 + _SLACK
    if direct * direct + quadrature * quadrature > current * current * slack:
        return False
    link = drive.dc_link
    along, across = steady_voltages(drive, electrical, direct, quadrature)
    power = power_of(drive, electrical, direct, quadrature)
    least, most = least_power(link, source), most_power(link, source)
    rounding = _SLACK * (most - least)
    if not least - rounding <= power <= most + rounding:
        return False
    voltage = LINEAR_LIMIT * max(link_voltage(link, source, power) - 2.0 * drive.switch_drop, 0.0)
    return along * along + across * across <= voltage * voltage * slack


@inlined
def _end_at(
    drive: PmAcDrive, source: float, electrical: float, direct: float, current: float, sign: float
) -> tuple[float, float]:
    """Return the greatest torque in a direction at a d-axis current, -inf if there is none, and its q-axis current."""
    square = current * current - direct * direct
    per_ampere = electrical_torque(drive, direct, 1.0)
    if square < 0.0 or per_ampere <= 0.0:
        return -inf, 0.0
    reach = sqrt(square)
    step = 2.0 * reach / _SCANNED
    for k in range(_SCANNED + 1):
        inside = sign * (reach - k * step)
        if not _is_within(drive, source, electrical, direct, inside, current):
            continue
        outside = inside + sign * step
        if k > 0:
            for _ in range(_HALVINGS):
                middle = 0.5 * (inside + outside)
                if _is_within(drive, source, electrical, direct, middle, current):
                    inside = middle
                else:
                    outside = middle
        return sign * per_ampere * inside, inside
    return -inf, 0.0


@inlined
def _best_of_half(
    drive: PmAcDrive, source: float, electrical: float, reach: float, sign: float
) -> tuple[float, float]:
    """Return the greatest torque in a direction, and its d-axis current, between zero and `reach` (A)."""
    current = abs(reach)
    step = current / _PLACES
    turn = 1.0 if reach > 0.0 else -1.0
    best, found = -inf, 0.0
    for k in range(_PLACES + 1):
        torque = _end_at(drive, source, electrical, turn * (k * step), current, sign)[0]
        if torque > best:
            best, found = torque, k * step
    if best == -inf:
        return -inf, 0.0
    low, high = max(found - step, 0.0), min(found + step, current)
    for _ in range(_NARROWINGS):
        inner = high - _GOLDEN * (high - low)
        outer = low + _GOLDEN * (high - low)
        at_inner = _end_at(drive, source, electrical, turn * inner, current, sign)[0]
        if at_inner >= _end_at(drive, source, electrical, turn * outer, current, sign)[0]:
            high = outer
        else:
            low = inner
    for place in (low, 0.5 * (low + high), high):
        torque = _end_at(drive, source, electrical, turn * place, current, sign)[0]
        if torque > best:
            best, found = torque, place
    return best, turn * found


@kernel
def greatest_on_link(
    drive: PmAcDrive, source: float, speed: float, current: float, sign: float, weakens: bool
) -> SteadyState:
    """Return the steady state of greatest torque within the limits of current, voltage and source.

    - `source`: voltage of the source (V).
    - `speed`: shaft speed, at least 0 (rad/s).
    - `current`: maximum peak current of a phase (A).
    - `sign`: `DRIVING` or `BRAKING`.
    - `weakens`: False to take the currents of maximum torque per ampere alone when driving.
    - Result: all NaN if no currents are within the limits. A braking torque is negative.
    """
    electrical = drive.pole_pairs * speed
    if not weakens and sign > 0.0:
        low, high = 0.0, current
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            direct, quadrature = most_torque_per_ampere(drive, middle)
            if _is_within(drive, source, electrical, direct, quadrature, current):
                low = middle
            else:
                high = middle
        direct, quadrature = most_torque_per_ampere(drive, low)
        if low > 0.0 or _is_within(drive, source, electrical, direct, quadrature, current):
            return steady_state(drive, speed, direct, quadrature)
        return steady_state(drive, speed, inf - inf, inf - inf)
    # With d-axis current of either sign a drive burns power, so each half has a summit.
    best, found = -inf, 0.0
    for half in (-1.0, 1.0):
        torque, direct = _best_of_half(drive, source, electrical, half * current, sign)
        if torque > best:
            best, found = torque, direct
    if best == -inf:
        return steady_state(drive, speed, inf - inf, inf - inf)
    quadrature = _end_at(drive, source, electrical, found, current, sign)[1]
    return steady_state(drive, speed, found, quadrature)
