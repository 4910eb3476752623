"""Integrals over a segment from the currents and their derivatives at its two ends.

Every integral is computed from value and three derivatives at both ends, with the two-point formula that is exact
for polynomials of degree 7. Over a length h the integral of f is the sum of ``h/2 f``, ``3 h**2/28 f'``, ``h**3/84
f''`` and ``h**4/1680 f'''`` at the first end, and of the same terms with the signs +, -, +, - at the second. In the
shortest segments the terms are ``h/2 f``, ``h**2/10 f'`` and ``h**3/120 f''``.
"""

from __future__ import annotations

from typing import Final, NamedTuple

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine.rotor_frame import RotorFrame, turned
from drivegate_models.pm_ac.plant.circuit import Circuit
from drivegate_models.pm_ac.plant.jets import Currents, Jet, in_stationary_frame, square_of, torque_of

SHORT: Final = 0.05
"""Maximum segment times the fastest rate (1).

The ninth term of the series is then below 1e-17. The relative error of the integral of a squared current that begins at
zero is at most 5e-13, and far smaller for any other current.
"""

SHORTEST: Final = 0.008
"""Maximum segment times the fastest rate for which third derivatives can be omitted (1).

The seventh term is then below 1e-17, and the relative error of the formula is below 3e-12 for the square of a current
that begins at zero.
"""


class Weights(NamedTuple):
    """Weights of value and derivatives at one end of a segment in an integral over it."""

    value: float
    slope: float
    bend: float
    jerk: float


class Sums(NamedTuple):
    """Integrals over a segment."""

    square: float
    """Integral of the squared d-q current (A2 s)."""
    torque: float
    """Integral of the torque over 1.5 times the pole pairs (V A s2)."""
    along: float
    """Integral of the current along the first phase's axis (A s)."""
    across: float
    """Integral of the current across the first phase's axis (A s)."""


@inlined
def _contribution(weights: Weights, one: Jet, is_shortest: bool) -> float:
    """Return the contribution of one end to an integral."""
    total = weights.value * one.value + weights.slope * one.slope + weights.bend * one.bend
    # Omit the term; a weight of zero would still be multiplied.
    return total if is_shortest else total + weights.jerk * one.jerk


@inlined
def sums_between(
    circuit: Circuit,
    begin: Currents,
    end: Currents,
    frame: RotorFrame,
    after: RotorFrame,
    length: float,
    is_shortest: bool,
) -> Sums:
    """Return the integrals over a segment.

    `length`: length of the segment (s). `is_shortest`: true to omit third derivatives. Result: exact to the errors
    stated at `SHORT` and `SHORTEST`.
    """
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
    first = in_stationary_frame(begin, circuit.electrical)
    last = in_stationary_frame(end, circuit.electrical)
    first_along, first_across = turned(
        frame,
        _contribution(weights, first.direct, is_shortest),
        _contribution(weights, first.quadrature, is_shortest),
    )
    last_along, last_across = turned(
        after,
        _contribution(behind, last.direct, is_shortest),
        _contribution(behind, last.quadrature, is_shortest),
    )
    return Sums(
        _contribution(weights, square_of(begin), is_shortest)
        + _contribution(behind, square_of(end), is_shortest),
        _contribution(weights, torque_of(circuit, begin), is_shortest)
        + _contribution(behind, torque_of(circuit, end), is_shortest),
        first_along + last_along,
        first_across + last_across,
    )
