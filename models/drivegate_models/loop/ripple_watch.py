"""Torque ripple of whole electrical periods in closed loop, from one control period to the next."""

from __future__ import annotations

from math import inf
from typing import Any, NamedTuple

from drivegate_models.compilation.kernels import inlined


class RippleWatch(NamedTuple):
    """The electrical period whose torque is followed."""

    lowest: float
    """Least torque so far (N m)."""
    highest: float
    """Greatest torque so far (N m)."""
    impulse: float
    """Integral of the torque so far (N m s)."""
    time: float
    """Time since it began (s)."""
    is_whole: bool
    """Whether it has been followed from its beginning."""


@inlined
def fresh_watch(is_whole: bool) -> RippleWatch:
    """Return the watch of an electrical period that begins.

    Parameters
    ----------
    is_whole : bool
        Whether it begins now, or has begun unwatched.

    Returns
    -------
    RippleWatch
        Nothing seen yet.
    """
    return RippleWatch(inf, -inf, 0.0, 0.0, is_whole)


@inlined
def widened_watch(
    watch: RippleWatch, lowest: float, highest: float, impulse: float, length: float
) -> RippleWatch:
    """Add one control period.

    Parameters
    ----------
    watch : RippleWatch
        The electrical period so far.
    lowest, highest : float
        Its extremes, this control period included (N m).
    impulse : float
        Integral of the torque over the control period (N m s).
    length : float
        Length of the control period (s).

    Returns
    -------
    RippleWatch
        With the control period.
    """
    return RippleWatch(lowest, highest, watch.impulse + impulse, watch.time + length, watch.is_whole)


@inlined
def observe_ripple(row: Any, watch: RippleWatch) -> None:
    """Add an electrical period that has ended to a window, if it was followed from its beginning.

    Parameters
    ----------
    row : record of WINDOW_RECORD
        Updated.
    watch : RippleWatch
        The electrical period.
    """
    mean = watch.impulse / watch.time
    if watch.is_whole:
        row.torque_lowest = min(row.torque_lowest, watch.lowest)
    if watch.is_whole and mean > 0.0:
        row.ripple = max(row.ripple, (watch.highest - watch.lowest) / mean)
        one_sided = max(watch.highest - mean, mean - watch.lowest) / mean
        row.ripple_one_sided = max(row.ripple_one_sided, one_sided)
