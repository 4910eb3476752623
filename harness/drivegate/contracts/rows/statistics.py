"""The statistics of a quantity over a stretch of a run: the least and the greatest value that they have in it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from drivegate.checks.means import exact_mean
from drivegate.checks.stretches import lasting_from

Values: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True)
class Extremes:
    """Least and greatest value of a statistic over the stretches of a window."""

    low: float
    low_at: int
    high: float
    high_at: int
    """Places of them in the window."""


Measure: TypeAlias = Callable[[Values, int], Extremes]
"""From the values of a window, shape (n,), and the length of its stretches, 0 for the whole, to the extremes."""


def _one(value: float, at: int = 0) -> Extremes:
    return Extremes(value, at, value, at)


def _of(lows: Values, highs: Values) -> Extremes:
    low, high = int(np.argmin(lows)), int(np.argmax(highs))
    return Extremes(float(lows[low]), low, float(highs[high]), high)


def _sustained(values: Values, stretch: int) -> tuple[Values, Values]:
    """Return for each stretch the greatest value that none in it exceeds, and the least that none falls below."""
    if stretch <= 1:
        return values, values
    return _greatest_of(values, stretch), -_greatest_of(-values, stretch)


def _greatest_of(values: Values, stretch: int) -> Values:
    """Return the greatest value of each stretch, from running maxima of blocks of its length (van Herk, 1992)."""
    filled = np.full(-(-len(values) // stretch) * stretch, -np.inf)
    filled[: len(values)] = values
    blocks = filled.reshape(-1, stretch)
    forward = np.maximum.accumulate(blocks, axis=1).ravel()
    backward = np.maximum.accumulate(blocks[:, ::-1], axis=1)[:, ::-1].ravel()
    count = len(values) - stretch + 1
    greatest: Values = np.maximum(backward[:count], forward[stretch - 1 : stretch - 1 + count])
    return greatest


def _value(values: Values, stretch: int) -> Extremes:
    return _of(*_sustained(values, stretch))


def _absolute(values: Values, stretch: int) -> Extremes:
    return _value(np.abs(values), stretch)


def _peak(values: Values, stretch: int) -> Extremes:
    found = _absolute(values, stretch)
    return _one(found.high, found.high_at)


def _means(values: Values, stretch: int) -> Values:
    # Sums one after the other are the same on every processor.
    sums = np.concatenate(([0.0], np.cumsum(values)))
    means: Values = (sums[stretch:] - sums[:-stretch]) / stretch
    return means


def _mean(values: Values, stretch: int) -> Extremes:
    if stretch == 0:
        return _one(exact_mean(values))
    means = _means(values, stretch)
    return _of(means, means)


def _rms(values: Values, stretch: int) -> Extremes:
    squares = _mean(values * values, stretch)
    low, high = (math.sqrt(max(value, 0.0)) for value in (squares.low, squares.high))
    return Extremes(low, squares.low_at, high, squares.high_at)


def _peak_to_peak(values: Values, stretch: int) -> Extremes:
    if stretch == 0:
        return _one(float(np.max(values) - np.min(values)), int(np.argmax(values)))
    highs, lows = _sustained(values, stretch)
    widths = highs - lows
    return _of(widths, widths)


def _sign_changes(values: Values, stretch: int) -> Extremes:
    """Count them; a zero has the sign of the value before it."""
    signs = np.sign(values)
    last = np.maximum.accumulate(np.where(signs != 0.0, np.arange(len(signs)), 0))
    carried = signs[last]
    changed = (carried[1:] * carried[:-1] < 0.0).astype(np.float64)
    if stretch == 0:
        return _one(float(np.sum(changed)))
    if stretch == 1:
        return _one(0.0)
    counts = np.round(_means(changed, stretch - 1) * (stretch - 1))
    return _of(counts, counts)


MEASURES: Final[Mapping[str, Measure]] = MappingProxyType(
    {
        "value": _value,
        "absolute": _absolute,
        "peak": _peak,
        "mean": _mean,
        "rms": _rms,
        "peak to peak": _peak_to_peak,
        "sign changes": _sign_changes,
    }
)
"""Every statistic but 'time until', by name."""


def place_reached(values: Values, low: float, high: float, stretch: int | None) -> int | None:
    """Return the first place from which values stay in a range: for a stretch, or to the end; None if they never do."""
    inside = (values >= low) & (values <= high)
    if stretch is None:
        first = lasting_from(inside)
        return first if first < len(values) else None
    counted = np.concatenate(([0], np.cumsum(inside)))
    length = max(stretch, 1)
    if len(values) < length:
        return None
    places = np.flatnonzero(counted[length:] - counted[:-length] == length)
    return int(places[0]) if len(places) else None
