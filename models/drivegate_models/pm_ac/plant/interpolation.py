"""A quantity within a segment: the polynomial of degree 7 through value and three derivatives at both ends.

At a share x of the segment it is ``(1 - x)**4 p(x) + x**4 q(1 - x)``, with p and q of degree 3: each end's series times
that of ``(1 - x)**-4``. For a current in a segment of at most `two_points.SHORT` its error is at most 1e-17 of the
current that the voltages build up within the time constant of the fastest rate.
"""

from __future__ import annotations

from typing import NamedTuple

from drivegate_models.compilation.kernels import inlined
from drivegate_models.pm_ac.plant.jets import Jet

# Coefficients of the powers of x in (1 - x)**-4.
_SECOND, _THIRD, _FOURTH = 4.0, 10.0, 20.0


class Coefficients(NamedTuple):
    """Coefficients of a polynomial of degree 3, in ascending order."""

    first: float
    second: float
    third: float
    fourth: float


class Interpolant(NamedTuple):
    """A quantity within a segment."""

    begin: Coefficients
    """Coefficients of p."""
    end: Coefficients
    """Coefficients of q."""


@inlined
def _coefficients(value: float, slope: float, bend: float, jerk: float) -> Coefficients:
    """Return one end's coefficients from the first four of its Taylor series over the segment."""
    return Coefficients(
        value,
        _SECOND * value + slope,
        _THIRD * value + _SECOND * slope + bend,
        _FOURTH * value + _THIRD * slope + _SECOND * bend + jerk,
    )


@inlined
def interpolant_of(begin: Jet, end: Jet, length: float) -> Interpolant:
    """Return the polynomial through value and three derivatives at both ends.

    `length`: length of the segment (s).
    """
    half = 0.5 * length * length
    sixth = (1.0 / 3.0) * length * half
    return Interpolant(
        _coefficients(begin.value, length * begin.slope, half * begin.bend, sixth * begin.jerk),
        _coefficients(end.value, -length * end.slope, half * end.bend, -sixth * end.jerk),
    )


@inlined
def _cubic(coefficients: Coefficients, at: float) -> float:
    """Return the value of a polynomial of degree 3."""
    return coefficients.first + at * (
        coefficients.second + at * (coefficients.third + at * coefficients.fourth)
    )


@inlined
def interpolated(interpolant: Interpolant, share: float) -> float:
    """Return the quantity at a share of the segment."""
    rest = 1.0 - share
    square, rest_square = share * share, rest * rest
    return rest_square * rest_square * _cubic(interpolant.begin, share) + square * square * _cubic(
        interpolant.end, rest
    )


@inlined
def interpolated_slope(begin: Jet, end: Jet, length: float, share: float) -> float:
    """Return the slope at a share of a segment, from slopes and second derivatives at its ends, to third order."""
    rest = 1.0 - share
    return rest * rest * (begin.slope + share * (2.0 * begin.slope + length * begin.bend)) + share * share * (
        end.slope + rest * (2.0 * end.slope - length * end.bend)
    )
