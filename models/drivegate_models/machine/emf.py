"""Back-EMF shapes as corner points of an odd, half-wave symmetric, piecewise linear function of angle.

A sine is approximated by straight pieces, with the error stated at the function.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drivegate_models.errors import InputError

_FIXED_POINT = 160
"""Fractional bits of fixed-point numbers, three times those of a double."""

Corners = tuple[NDArray[np.float64], NDArray[np.float64]]


def trapezoid_corners(flat: float) -> Corners:
    """Return the corners of a trapezoidal back-EMF over one positive half cycle.

    `flat`: width of the flat top (rad electrical), 0 to below pi. Zero results in a triangle. Returns `angles`,
    `values`, shape (k,): corner angles (rad) in [0, pi), the first of them 0, and the shape's values there (1). Raises
    InputError if the flat width is outside its range.
    """
    if not 0.0 <= flat < np.pi:
        raise InputError(f"the flat width is {np.degrees(flat):g} deg; it must lie in 0 to below 180 deg")
    rise = 0.5 * (np.pi - flat)
    if rise >= np.pi - rise:
        return np.array([0.0, rise]), np.array([0.0, 1.0])
    return np.array([0.0, rise, np.pi - rise]), np.array([0.0, 1.0, 1.0])


def sine_corners(pieces: int = 90) -> Corners:
    """Return the corners of a sine in equal straight pieces.

    A chord lies below the sine by at most ``(pi / pieces)**2 / 8``: 1.5e-4 of the peak with 90 pieces.

    `pieces`: number of pieces of the positive half cycle, even so that the peak is a corner. Returns `angles`,
    `values`, shape (pieces,): corner angles (rad) and the sine's values there (1).
    """
    angles = np.linspace(0.0, np.pi, pieces, endpoint=False, dtype=np.float64)
    return angles, np.array([_sine(float(angle)) for angle in angles])


def _sine(angle: float) -> float:
    """Return the correctly rounded sine; sines of libraries differ between processors in the last place."""
    numerator, denominator = angle.as_integer_ratio()
    fixed = (numerator << _FIXED_POINT) // denominator
    square = fixed * fixed >> _FIXED_POINT
    total, term, order = fixed, fixed, 1
    while term:
        term = (term * square >> _FIXED_POINT) // ((order + 1) * (order + 2))
        order += 2
        total += term if order % 4 == 1 else -term
    return total / (1 << _FIXED_POINT)


def table_corners(angles: ArrayLike, values: ArrayLike) -> Corners:
    """Return the corners of a measured shape, joined by straight lines.

    `angles`, shape (k,): angles (rad), increasing from 0 to pi. `values`, shape (k,): values (1), zero at both ends,
    peak 1. Returns `angles`, `values`, shape (k - 1,): the corners without the last point, which the half-wave symmetry
    repeats. Raises InputError if the table does not describe one positive half cycle.
    """
    angle_array = np.asarray(angles, dtype=np.float64)
    value_array = np.asarray(values, dtype=np.float64)
    if angle_array.size != value_array.size or angle_array.size < 3 or np.any(np.diff(angle_array) <= 0.0):
        raise InputError("the back-EMF table needs three or more points at increasing angles")
    if angle_array[0] != 0.0 or abs(angle_array[-1] - np.pi) > 1e-9:
        raise InputError("the back-EMF table must run from 0 to 180 electrical degrees")
    if value_array[0] != 0.0 or value_array[-1] != 0.0 or abs(np.max(np.abs(value_array)) - 1.0) > 1e-9:
        raise InputError("the back-EMF table must be 0 at both ends and have a peak of 1")
    return angle_array[:-1], value_array[:-1]


def drive_fields(
    *,
    phases: int,
    pole_pairs: int,
    emf_angles: NDArray[np.float64],
    emf_values: NDArray[np.float64],
    **constants: float,
) -> dict[str, Any]:
    """Return the fields that the constants of every drive with a back-EMF shape have, in SI units.

    `emf_angles`, `emf_values`, shape (k,): corners of the shape's positive half cycle in [0, pi) (rad, 1). `constants`:
    the other fields, in their units; missing ones have their defaults. Result: with the 2 k + 1 corners of the whole
    cycle, both ends included, where f(x + pi) = -f(x).
    """
    angles = np.concatenate([emf_angles, emf_angles + np.pi, [2.0 * np.pi]])
    values = np.concatenate([emf_values, -emf_values, emf_values[:1]])
    # Each kernel is compiled for one type of drive; an int instead of a float would compile it a second time.
    return {
        "phases": int(phases),
        "pole_pairs": int(pole_pairs),
        "emf_angles": angles,
        "emf_values": values,
        "emf_slopes": np.diff(values) / np.diff(angles),
        **{name: float(constant) for name, constant in constants.items()},
    }
