"""Torque ripple of whole electrical periods in closed loop, accumulated one control period at a time."""

from __future__ import annotations

from math import inf
from typing import Any, NamedTuple

from drivegate_models.compilation.kernels import inlined


class RippleWatch(NamedTuple):
    """The electrical period whose torque is observed."""

    lowest: float
    """Minimum torque so far (N m)."""
    highest: float
    """Maximum torque so far (N m)."""
    impulse: float
    """Integral of the torque so far (N m s)."""
    time: float
    """Time since it began (s)."""
    is_whole: bool
    """True if it was observed from its beginning."""


@inlined
def fresh_watch(is_whole: bool) -> RippleWatch:
    """Return the watch of an electrical period without any torque observed yet.

    `is_whole`: true if the electrical period begins now, False if part of it has passed unobserved. Result: with an
    infinite minimum, a negative infinite maximum and zero sums.
    """
    return RippleWatch(inf, -inf, 0.0, 0.0, is_whole)


@inlined
def widened_watch(
    watch: RippleWatch, lowest: float, highest: float, impulse: float, length: float
) -> RippleWatch:
    """Return the watch with one more control period.

    `lowest`, `highest`: torque extremes since its beginning, this control period included (N m). `impulse`: integral
    of the torque over the control period (N m s). `length`: length of the control period (s).
    """
    return RippleWatch(lowest, highest, watch.impulse + impulse, watch.time + length, watch.is_whole)


@inlined
def observe_ripple(row: Any, watch: RippleWatch) -> None:
    """Add a completed electrical period to a window if it was observed from its beginning.

    `row`: the window; its torque minimum and its ripple of the worst electrical period are updated.
    """
    mean = watch.impulse / watch.time
    if watch.is_whole:
        row.torque_lowest = min(row.torque_lowest, watch.lowest)
    if watch.is_whole and mean > 0.0:
        row.ripple = max(row.ripple, (watch.highest - watch.lowest) / mean)
        one_sided = max(watch.highest - mean, mean - watch.lowest) / mean
        row.ripple_one_sided = max(row.ripple_one_sided, one_sided)
