"""Sine and cosine from operations that every processor rounds identically; libraries differ in the last place."""

from __future__ import annotations

from math import floor
from typing import Final

from drivegate_models.compilation.kernels import inlined

GREATEST: Final = 1e5
"""Maximum angle that is reduced to a quarter turn without loss (rad)."""

# The first 33 bits of a quarter turn, so that whole multiples of them are exact, and the rest.
_QUARTER_HIGH: Final = 1.57079632673412561417e00
_QUARTER_LOW: Final = 6.07710050650619224932e-11
_QUARTERS: Final = 6.36619772367581382433e-01

# Coefficients of fdlibm for a quarter turn about zero.
_S1, _S2, _S3 = -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04
_S4, _S5, _S6 = 2.75573137070700676789e-06, -2.50507602534068634195e-08, 1.58969099521155010221e-10
_C1, _C2, _C3 = 4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05
_C4, _C5, _C6 = -2.75573143513906633035e-07, 2.08757232129817482790e-09, -1.13596475577881948265e-11


@inlined
def small_cosine_sine(angle: float) -> tuple[float, float]:
    """Return cosine and sine of an angle of at most pi/4 in magnitude (rad), within one unit in the last place.

    The polynomials are those of fdlibm.
    """
    z = angle * angle
    cubic = _S1 + z * (_S2 + z * (_S3 + z * (_S4 + z * (_S5 + z * _S6))))
    quartic = _C1 + z * (_C2 + z * (_C3 + z * (_C4 + z * (_C5 + z * _C6))))
    half = 0.5 * z
    rounded = 1.0 - half
    return rounded + (((1.0 - rounded) - half) + z * z * quartic), angle + angle * z * cubic


@inlined
def cosine_sine(angle: float) -> tuple[float, float]:
    """Return cosine and sine of an angle of at most `GREATEST` in magnitude (rad).

    The error is about 1e-16 for angles of a few turns.
    """
    quarters = floor(angle * _QUARTERS + 0.5)
    cosine, sine = small_cosine_sine((angle - quarters * _QUARTER_HIGH) - quarters * _QUARTER_LOW)
    turn = int(quarters) & 3
    if turn == 0:
        return cosine, sine
    if turn == 1:
        return -sine, cosine
    if turn == 2:
        return -cosine, -sine
    return sine, -cosine


@inlined
def small_argument(real: float, imaginary: float) -> float:
    """Return the argument of a complex number, at most pi/4 in magnitude (rad), within a few units in the last place.

    Each correction leaves the fifth power of the error before it.
    """
    tangent = imaginary / real
    angle = 0.0
    for _ in range(3):
        angle += tangent - tangent * tangent * tangent / 3.0
        cosine, sine = cosine_sine(angle)
        tangent = (imaginary * cosine - real * sine) / (real * cosine + imaginary * sine)
    return angle
