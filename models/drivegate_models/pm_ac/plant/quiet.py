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
from drivegate_models.machine.rotor_frame import HALF_ROOT, RotorFrame
from drivegate_models.machine.sine import small_cosine_sine
from drivegate_models.pm_ac.plant.circuit import Circuit, rotor_voltages
from drivegate_models.pm_ac.plant.integrals import add_charge, supply_leg
from drivegate_models.pm_ac.plant.jets import (
    Currents,
    Jet,
    Rates,
    derivatives,
    square_of,
    standing,
    torque_of,
)
from drivegate_models.pm_ac.plant.settling import FREE, Legs

SHORT: Final = 0.05
"""Longest segment over the time of the fastest rate (1).

The ninth term of the series is then below 1e-17, and the integral of the square of a current that begins at zero is
exact to 5e-13 of itself; that of any other far more."""

# The same up to which the seventh term is below 1e-17, and the formula without third derivatives leaves less than 3e-12
# of the square of a current that begins at zero.
_SHORTEST = 0.008


class Weights(NamedTuple):
    """Of value and derivatives at one end of a segment in an integral over it."""

    value: float
    slope: float
    bend: float
    jerk: float


class Sums(NamedTuple):
    """Integrals over a segment."""

    square: float
    """Of the squares of the currents of the rotor frame (A2 s)."""
    torque: float
    """Of the torque over three halves of the pole pairs (V A s2)."""
    along: float
    """Of the current along where the magnet's axis was at the start (A s)."""
    across: float
    """Of that across it (A s)."""


class Passed(NamedTuple):
    """What has become of a segment."""

    is_quiet: bool
    """Whether nothing could happen in it; where it is not, nothing has been added."""
    frame: RotorFrame
    """At its end."""


@inlined
def _at_end(
    rates: Rates, begin: Currents, driven: float, driven_across: float, length: float, is_shortest: bool
) -> tuple[float, float]:
    """Return the currents at the end of a segment (A)."""
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
        if is_shortest and order == 7:
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
def _part(weights: Weights, one: Jet, is_shortest: bool) -> float:
    """Return what one end gives to an integral."""
    total = weights.value * one.value + weights.slope * one.slope + weights.bend * one.bend
    # Not a weight of zero, which would be multiplied by all the same.
    return total if is_shortest else total + weights.jerk * one.jerk


@inlined
def _sums(
    circuit: Circuit, begin: Currents, end: Currents, turn: RotorFrame, length: float, is_shortest: bool
) -> Sums:
    """Return the integrals over a segment that turns the rotor by an angle of a given cosine and sine."""
    square = length * length
    if is_shortest:
        weights = Weights(0.5 * length, 0.1 * square, (1.0 / 120.0) * square * length, 0.0)
    else:
        weights = Weights(
            0.5 * length,
            (3.0 / 28.0) * square,
            (1.0 / 84.0) * square * length,
            (1.0 / 1680.0) * square * square,
        )
    behind = Weights(weights.value, -weights.slope, weights.bend, -weights.jerk)
    first = standing(begin, circuit.electrical)
    last = standing(end, circuit.electrical)
    along, across = _turn(
        turn, _part(behind, last.direct, is_shortest), _part(behind, last.quadrature, is_shortest)
    )
    return Sums(
        _part(weights, square_of(begin), is_shortest) + _part(behind, square_of(end), is_shortest),
        _part(weights, torque_of(circuit, begin), is_shortest)
        + _part(behind, torque_of(circuit, end), is_shortest),
        along + _part(weights, first.direct, is_shortest),
        across + _part(weights, first.quadrature, is_shortest),
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
    ``h**4/1680 f'''`` at the first, and of the same with the signs +, -, +, - at the second; in the shortest segments
    of ``h/2 f``, ``h**2/10 f'`` and ``h**3/120 f''``.
    """
    is_shortest = circuit.rate * length <= _SHORTEST
    voltages = legs.voltages
    direct, quadrature = rotor_voltages(frame, voltages[0], voltages[1], voltages[2])
    driven = direct * rates.per_direct
    across = quadrature * rates.per_quadrature
    begin = derivatives(rates, frame.direct, frame.quadrature, driven, across)
    end_d, end_q = _at_end(rates, begin, driven, across, length, is_shortest)
    cosine, sine = small_cosine_sine(circuit.electrical * length)
    end = derivatives(
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
    begin_standing = standing(begin, circuit.electrical)
    end_standing = standing(end, circuit.electrical)
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

    turn = RotorFrame(0.0, 0.0, cosine, sine)
    # Twice, so that each is compiled without what the other alone needs.
    if is_shortest:
        sums = _sums(circuit, begin, end, turn, length, True)
    else:
        sums = _sums(circuit, begin, end, turn, length, False)
    totals[ledger.SQUARE] += 1.5 * sums.square
    totals[ledger.IMPULSE] += 1.5 * pole_pairs * sums.torque
    along, across = _turn(frame, sums.along, sums.across)
    supply = supply_leg(legs, FREE)
    for leg in range(3):
        charge = _of_phase(leg, along, across)
        add_charge(circuit, legs, leg, supply, charge, abs(charge), magnitudes, totals)
    return Passed(True, after)
