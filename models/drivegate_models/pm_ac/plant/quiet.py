"""A short segment in which no current comes near an event: by the derivatives of the currents at its two ends.

The equations of the rotor frame give all derivatives of the currents for a few products each. The first eight and
their Taylor series lead to the end; value and three derivatives at both ends give every integral, with the two-point
formula that is exact for polynomials of degree 7.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine import ledger
from drivegate_models.machine.sine import small_cosine_sine
from drivegate_models.pm_ac.plant.circuit import HALF_ROOT, Circuit, RotorFrame, rotor_voltages
from drivegate_models.pm_ac.plant.integrals import add_charge, supply_leg
from drivegate_models.pm_ac.plant.settling import FREE, Legs

SHORT: Final = 0.05
"""Longest segment over the time of the fastest rate (1).

The ninth term of the series is then below 1e-17, and the integral of the square of a current that begins at zero is
exact to 5e-13 of itself; that of any other far more."""

# The same up to which the seventh term is below 1e-17.
_SIX_TERMS = 0.0125


class Jet(NamedTuple):
    """A quantity and its derivatives by time at one instant."""

    value: float
    slope: float
    bend: float
    jerk: float


class Currents(NamedTuple):
    """The currents of the rotor frame, or of axes that stand still and lie where its axes are at the instant (A)."""

    direct: Jet
    quadrature: Jet


class Weights(NamedTuple):
    """Of value and derivatives at one end of a segment in an integral over it."""

    value: float
    slope: float
    bend: float
    jerk: float


class Rates(NamedTuple):
    """The equations of the rotor frame, solved for the slopes of the currents."""

    direct: float
    """-R/L_d (1/s)."""
    direct_turning: float
    """w L_q/L_d (1/s)."""
    quadrature_turning: float
    """-w L_d/L_q (1/s)."""
    quadrature: float
    """-R/L_q (1/s)."""
    per_direct: float
    """1/L_d (1/H)."""
    per_quadrature: float
    """1/L_q (1/H)."""
    opposed: float
    """w psi/L_q (A/s)."""


class Passed(NamedTuple):
    """What has become of a segment."""

    is_quiet: bool
    """Whether nothing could happen in it; where it is not, nothing has been added."""
    frame: RotorFrame
    """At its end."""


@inlined
def rates_of(circuit: Circuit) -> Rates:
    """Return the equations of an advance."""
    per_direct = 1.0 / circuit.direct
    per_quadrature = 1.0 / circuit.quadrature
    return Rates(
        -circuit.resistance * per_direct,
        circuit.electrical * circuit.quadrature * per_direct,
        -circuit.electrical * circuit.direct * per_quadrature,
        -circuit.resistance * per_quadrature,
        per_direct,
        per_quadrature,
        circuit.electrical * circuit.flux * per_quadrature,
    )


@inlined
def _derivatives(
    rates: Rates, direct: float, quadrature: float, driven: float, driven_across: float
) -> Currents:
    """Return the currents and their derivatives, from the slopes that the voltages alone would give them (A/s)."""
    slope_d = rates.direct * direct + rates.direct_turning * quadrature + driven
    slope_q = (
        rates.quadrature_turning * direct + rates.quadrature * quadrature + (driven_across - rates.opposed)
    )
    bend_d = rates.direct * slope_d + rates.direct_turning * (slope_q + driven_across)
    bend_q = rates.quadrature_turning * (slope_d + driven) + rates.quadrature * slope_q
    # The voltages turn backward in the rotor frame.
    turned_d = rates.direct_turning * driven_across
    turned_q = rates.quadrature_turning * driven
    jerk_d = rates.direct * bend_d + rates.direct_turning * (bend_q + turned_q)
    jerk_q = rates.quadrature_turning * (bend_d + turned_d) + rates.quadrature * bend_q
    return Currents(Jet(direct, slope_d, bend_d, jerk_d), Jet(quadrature, slope_q, bend_q, jerk_q))


@inlined
def _at_end(
    rates: Rates, begin: Currents, driven: float, driven_across: float, length: float, reach: float
) -> tuple[float, float]:
    """Return the currents at the end of a segment (A)."""
    is_shorter = reach <= _SIX_TERMS
    power = 0.5 * length * length
    direct = length * begin.direct.slope + power * begin.direct.bend
    quadrature = length * begin.quadrature.slope + power * begin.quadrature.bend
    power *= length * (1.0 / 3.0)
    last_d = begin.direct.jerk
    last_q = begin.quadrature.jerk
    direct += power * last_d
    quadrature += power * last_q
    # Voltages of the derivatives from the third on: two derivatives turn them by half a turn.
    square = rates.direct_turning * rates.quadrature_turning
    driven *= square
    driven_across *= square
    for order in range(4, 9):
        if is_shorter and order == 7:
            break
        last_d, last_q = (
            rates.direct * last_d + rates.direct_turning * (last_q + driven_across),
            rates.quadrature_turning * (last_d + driven) + rates.quadrature * last_q,
        )
        driven, driven_across = rates.direct_turning * driven_across, rates.quadrature_turning * driven
        power *= length * (1.0 / order)
        direct += power * last_d
        quadrature += power * last_q
    return begin.direct.value + direct, begin.quadrature.value + quadrature


@inlined
def _product(one: Jet, other: Jet) -> Jet:
    """Return a product and its derivatives."""
    return Jet(
        one.value * other.value,
        one.slope * other.value + one.value * other.slope,
        one.bend * other.value + 2.0 * one.slope * other.slope + one.value * other.bend,
        one.jerk * other.value
        + 3.0 * (one.bend * other.slope + one.slope * other.bend)
        + one.value * other.jerk,
    )


@inlined
def _square(one: Jet) -> Jet:
    """Return a square and its derivatives."""
    return Jet(
        one.value * one.value,
        2.0 * one.value * one.slope,
        2.0 * (one.slope * one.slope + one.value * one.bend),
        2.0 * (3.0 * one.slope * one.bend + one.value * one.jerk),
    )


@inlined
def _standing(currents: Currents, electrical: float) -> Currents:
    """Return the currents along axes that stand still where those of the rotor are at the instant."""
    d, q = currents.direct, currents.quadrature
    twice = 2.0 * electrical
    thrice = 3.0 * electrical
    square = electrical * electrical
    return Currents(
        Jet(
            d.value,
            d.slope - electrical * q.value,
            d.bend - twice * q.slope - square * d.value,
            d.jerk - thrice * (q.bend + electrical * d.slope) + square * electrical * q.value,
        ),
        Jet(
            q.value,
            q.slope + electrical * d.value,
            q.bend + twice * d.slope - square * q.value,
            q.jerk + thrice * (d.bend - electrical * q.slope) - square * electrical * d.value,
        ),
    )


@inlined
def _part(weights: Weights, one: Jet) -> float:
    """Return what one end gives to an integral."""
    return (
        weights.value * one.value
        + weights.slope * one.slope
        + weights.bend * one.bend
        + weights.jerk * one.jerk
    )


@inlined
def _curvature(circuit: Circuit, begin: Currents, length: float) -> float:
    """Return a bound of the bend of any phase current over a segment (A/s2)."""
    direct, quadrature = begin.direct, begin.quadrature
    reach = circuit.pace * length
    size = abs(direct.bend) + abs(quadrature.bend) + length * (abs(direct.jerk) + abs(quadrature.jerk))
    return size + 0.5 * reach * reach * circuit.bend


@inlined
def _of_phase(leg: int, along: float, across: float) -> float:
    """Return the share of a phase in a quantity along and across the first phase's axis."""
    if leg == 0:
        return along
    return -0.5 * along + (HALF_ROOT if leg == 1 else -HALF_ROOT) * across


@inlined
def _keeps_sign(legs: Legs, leg: int, begin: float, end: float, is_monotone: bool, deviation: float) -> bool:
    """Return whether a current keeps its sign, and that which its leg has."""
    if legs.sure[leg] != 0:
        return True
    sign = legs.signs[leg]
    least = min(sign * begin, sign * end)
    return bool(least > deviation or (is_monotone and least >= 0.0))


@inlined
def _turn(frame: RotorFrame, along: float, across: float) -> tuple[float, float]:
    """Return a quantity of the rotor's axes along and across the first phase's axis."""
    return frame.cosine * along - frame.sine * across, frame.sine * along + frame.cosine * across


@inlined
def pass_quietly(
    pole_pairs: float,
    circuit: Circuit,
    rates: Rates,
    legs: Legs,
    frame: RotorFrame,
    length: float,
    magnitudes: NDArray[np.float64],
    totals: NDArray[np.float64],
) -> Passed:
    """Pass a segment in which no leg is held and add it to the ledger, if no current comes near an event in it.

    Parameters
    ----------
    pole_pairs : float
        Of the machine (1).
    circuit : Circuit
        Constants of the advance.
    rates : Rates
        Its equations.
    legs : Legs
        Signs and voltages.
    frame : RotorFrame
        At the segment's start.
    length : float
        Its length, at most `SHORT` over the circuit's rate (s).
    magnitudes : ndarray, shape (3,)
        Integral of each phase's current magnitude (A s), added to.
    totals : ndarray, shape (ledger.ENTRIES,)
        Exact integrals, added to.

    Returns
    -------
    Passed
        Not quiet where a current may come to zero, or be greatest within the segment.

    Notes
    -----
    Between two instants h apart the integral of f is the sum of ``h/2 f``, ``3 h**2/28 f'``, ``h**3/84 f''`` and
    ``h**4/1680 f'''`` at the first, and of the same with the signs +, -, +, - at the second.
    """
    voltages = legs.voltages
    direct, quadrature = rotor_voltages(frame, voltages[0], voltages[1], voltages[2])
    driven = direct * rates.per_direct
    across = quadrature * rates.per_quadrature
    begin = _derivatives(rates, frame.direct, frame.quadrature, driven, across)
    end_d, end_q = _at_end(rates, begin, driven, across, length, circuit.rate * length)
    cosine, sine = small_cosine_sine(circuit.electrical * length)
    end = _derivatives(
        rates,
        end_d,
        end_q,
        (cosine * direct + sine * quadrature) * rates.per_direct,
        (cosine * quadrature - sine * direct) * rates.per_quadrature,
    )
    after = RotorFrame(
        end_d,
        end_q,
        frame.cosine * cosine - frame.sine * sine,
        frame.sine * cosine + frame.cosine * sine,
    )
    begin_standing = _standing(begin, circuit.electrical)
    end_standing = _standing(end, circuit.electrical)
    begin_a, begin_b = _turn(frame, begin.direct.value, begin.quadrature.value)
    end_a, end_b = _turn(after, end_d, end_q)
    begin_slope_a, begin_slope_b = _turn(frame, begin_standing.direct.slope, begin_standing.quadrature.slope)
    end_slope_a, end_slope_b = _turn(after, end_standing.direct.slope, end_standing.quadrature.slope)
    change = 0.5 * length * _curvature(circuit, begin_standing, length)
    deviation = 0.25 * length * change
    peak = totals[ledger.PEAK]
    for leg in range(3):
        first = _of_phase(leg, begin_a, begin_b)
        last = _of_phase(leg, end_a, end_b)
        first_slope = _of_phase(leg, begin_slope_a, begin_slope_b)
        last_slope = _of_phase(leg, end_slope_a, end_slope_b)
        is_monotone = min(first_slope, last_slope) > change or max(first_slope, last_slope) < -change
        top = max(abs(first), abs(last))
        if not is_monotone and top + deviation > peak:
            return Passed(False, frame)
        if not _keeps_sign(legs, leg, first, last, is_monotone, deviation):
            return Passed(False, frame)
        peak = max(peak, top)
    totals[ledger.PEAK] = peak

    weights = Weights(
        0.5 * length,
        (3.0 / 28.0) * length * length,
        (1.0 / 84.0) * length * length * length,
        (1.0 / 1680.0) * length * length * length * length,
    )
    behind = Weights(weights.value, -weights.slope, weights.bend, -weights.jerk)
    totals[ledger.SQUARE] += 1.5 * (
        _part(weights, _square(begin.direct))
        + _part(weights, _square(begin.quadrature))
        + _part(behind, _square(end.direct))
        + _part(behind, _square(end.quadrature))
    )
    product = _part(weights, _product(begin.direct, begin.quadrature)) + _part(
        behind, _product(end.direct, end.quadrature)
    )
    linear = _part(weights, begin.quadrature) + _part(behind, end.quadrature)
    saliency = circuit.direct - circuit.quadrature
    totals[ledger.IMPULSE] += 1.5 * pole_pairs * (circuit.flux * linear + saliency * product)
    first_a, first_b = _turn(
        frame, _part(weights, begin_standing.direct), _part(weights, begin_standing.quadrature)
    )
    last_a, last_b = _turn(after, _part(behind, end_standing.direct), _part(behind, end_standing.quadrature))
    supply = supply_leg(legs, FREE)
    for leg in range(3):
        charge = _of_phase(leg, first_a + last_a, first_b + last_b)
        add_charge(circuit, legs, leg, supply, charge, abs(charge), magnitudes, totals)
    return Passed(True, after)
