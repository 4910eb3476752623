"""Duty ratios of a voltage for each kind of modulation: the zero sequence decides which leg is clamped."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine.rotor_frame import HALF_ROOT, of_phase
from drivegate_models.pm_ac.modulation_kind import CONTINUOUS, DPWM_0, DPWM_1, DPWM_2, DPWM_3, DPWM_MIN

UPPER_RAIL: Final = 1
"""The leg of the highest voltage is clamped to the upper rail."""
LOWER_RAIL: Final = -1
"""The leg of the lowest voltage is clamped to the lower rail."""
NO_RAIL: Final = 0
"""No leg is clamped."""


@inlined
def _extremes(along: float, across: float) -> tuple[float, float]:
    """Return the lowest and the highest phase voltage of a voltage in the stationary frame (V)."""
    second, third = of_phase(1, along, across), of_phase(2, along, across)
    return min(along, second, third), max(along, second, third)


@inlined
def clamped_rail(kind: int, along: float, across: float, sense: float) -> int:
    """Return the rail to which a kind of modulation clamps a leg.

    `along`, `across`: voltage in the stationary frame (V). `sense`: 1 if that turns forward, -1 if backward. Result:
    `UPPER_RAIL`, `LOWER_RAIL` or `NO_RAIL`.
    """
    if kind == CONTINUOUS:
        return NO_RAIL
    turned_along, turned_across = along, across
    if kind in (DPWM_0, DPWM_2):
        # A voltage turned by 30 degrees has its peaks where the middle of the clamped sixth is to be.
        sine = 0.5 * sense if kind == DPWM_0 else -0.5 * sense
        turned_along = HALF_ROOT * along - sine * across
        turned_across = sine * along + HALF_ROOT * across
    least, most = _extremes(turned_along, turned_across)
    if kind in (DPWM_0, DPWM_1, DPWM_2):
        return UPPER_RAIL if most + least > 0.0 else LOWER_RAIL
    if kind == DPWM_3:
        return LOWER_RAIL if most + least > 0.0 else UPPER_RAIL
    return LOWER_RAIL if kind == DPWM_MIN else UPPER_RAIL


@inlined
def write_ratios(ratios: NDArray[np.float64], along: float, across: float, link: float, rail: int) -> None:
    """Write the duty ratios of a voltage.

    The zero sequence centres the lowest and the highest duty ratio, which are those of space vectors with equal zero
    vectors (Holmes and Lipo, "Pulse Width Modulation for Power Converters", IEEE Press, 2003, chapter 6), or makes one
    of them 0 or 1.

    `ratios`, shape (3,): receives them (1). `along`, `across`: voltage in the stationary frame (V). `link`: voltage of
    the dc link (V). `rail`: as `clamped_rail` returns it.
    """
    least, most = _extremes(along, across)
    base, level = 0.5 * (most + least), 0.5
    if rail == UPPER_RAIL:
        base, level = most, 1.0
    elif rail == LOWER_RAIL:
        base, level = least, 0.0
    for leg in range(3):
        ratios[leg] = level + (of_phase(leg, along, across) - base) / link
