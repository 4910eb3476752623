"""Integrals over a segment from the currents and their derivatives at its two ends.

Value and three derivatives at both ends give every integral, with the two-point formula that is exact for polynomials
of degree 7: between two instants h apart the integral of f is the sum of ``h/2 f``, ``3 h**2/28 f'``, ``h**3/84 f''``
and ``h**4/1680 f'''`` at the first, and of the same with the signs +, -, +, - at the second; in the shortest segments
of ``h/2 f``, ``h**2/10 f'`` and ``h**3/120 f''``.
"""

from __future__ import annotations

from typing import Final, NamedTuple

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine.rotor_frame import RotorFrame, turned
from drivegate_models.pm_ac.plant.circuit import Circuit
from drivegate_models.pm_ac.plant.jets import Currents, Jet, square_of, standing, torque_of

SHORT: Final = 0.05
"""Longest segment over the time of the fastest rate (1).

The ninth term of the series is then below 1e-17, and the integral of the square of a current that begins at zero is
exact to 5e-13 of itself; that of any other far more."""

SHORTEST: Final = 0.008
"""The same up to which third derivatives can be left out (1).

The seventh term is then below 1e-17, and the formula leaves less than 3e-12 of the square of a current that begins at
zero.
"""


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
    """Of the current along the first phase's axis (A s)."""
    across: float
    """Of that across it (A s)."""


@inlined
def _part(weights: Weights, one: Jet, is_shortest: bool) -> float:
    """Return what one end gives to an integral."""
    total = weights.value * one.value + weights.slope * one.slope + weights.bend * one.bend
    # Not a weight of zero, which would be multiplied by all the same.
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

    Parameters
    ----------
    circuit : Circuit
        Constants of the advance.
    begin, end : Currents
        With their derivatives at both ends.
    frame, after : RotorFrame
        At both ends.
    length : float
        (s).
    is_shortest : bool
        Whether third derivatives are left out.

    Returns
    -------
    Sums
        The integrals.
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
    first = standing(begin, circuit.electrical)
    last = standing(end, circuit.electrical)
    first_along, first_across = turned(
        frame, _part(weights, first.direct, is_shortest), _part(weights, first.quadrature, is_shortest)
    )
    last_along, last_across = turned(
        after, _part(behind, last.direct, is_shortest), _part(behind, last.quadrature, is_shortest)
    )
    return Sums(
        _part(weights, square_of(begin), is_shortest) + _part(behind, square_of(end), is_shortest),
        _part(weights, torque_of(circuit, begin), is_shortest)
        + _part(behind, torque_of(circuit, end), is_shortest),
        first_along + last_along,
        first_across + last_across,
    )
