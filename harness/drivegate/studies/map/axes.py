"""The grid of an operating map: axes as people write them, and every point of their product."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite, prod
from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate_cases.documents.wording import nearest, one_line, shown
from drivegate_models.errors import InputError

MOST_POINTS: Final = 20_000_000
"""Points of a map at most."""
_FEWEST = 2
_MOST_VALUES = 100_000
_RANGE_PARTS = 3


@dataclass(frozen=True)
class MapAxes:
    """The axes of a map, the last of which varies fastest."""

    names: tuple[str, ...]
    """Names of the axes, with their units."""
    values: tuple[tuple[float, ...], ...]
    """Values of each."""

    @classmethod
    def of(cls, axes: Mapping[str, Sequence[float]]) -> MapAxes:
        """Make axes of a table of values."""
        made = cls(tuple(axes), tuple(tuple(values) for values in axes.values()))
        if made.points > MOST_POINTS:
            raise InputError(f"the map has {made.points} points, but must have at most {MOST_POINTS}")
        return made

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each axis."""
        return tuple(len(values) for values in self.values)

    @property
    def points(self) -> int:
        """Number of points."""
        return prod(self.shape)

    def coordinates(self, first: int, last: int) -> dict[str, NDArray[np.float64]]:
        """Return the coordinates of some points."""
        places = np.unravel_index(np.arange(first, last), self.shape)
        return {
            name: np.asarray(values, dtype=np.float64)[place]
            for name, values, place in zip(self.names, self.values, places, strict=True)
        }


def axis_within(lowest: float, highest: float, *, above: bool = False) -> Callable[[str], tuple[float, ...]]:
    """Make a reader of axes whose values lie within limits."""

    def read(text: str) -> tuple[float, ...]:
        values = _values(text)
        if values is None:
            raise InputError(
                f"it is {shown(text)}, but must be LOW:HIGH:COUNT with LOW below HIGH and a COUNT from "
                f"{_FEWEST} to {_MOST_VALUES}, a list such as 700,1000,1500, or a number"
            )
        if len(set(values)) < len(values):
            raise InputError(f"it is {shown(text)}, in which a value stands twice")
        wrong = [value for value in values if not lowest <= value <= highest or (above and value == lowest)]
        if wrong:
            raise InputError(
                f"it has {wrong[0]:g}, but must be {'above' if above else 'from'} {lowest:g}"
                f"{' and up' if above else ''} to {highest:g}"
            )
        return values

    return read


def _values(text: str) -> tuple[float, ...] | None:
    try:
        if ":" in text:
            parts = text.split(":")
            count = int(parts[2]) if len(parts) == _RANGE_PARTS else 0
            low, high = float(parts[0]), float(parts[1])
            if not _FEWEST <= count <= _MOST_VALUES or not (isfinite(low) and isfinite(high)) or low >= high:
                return None
            return tuple(float(value) for value in np.linspace(low, high, count))
        values = tuple(float(part) for part in text.split(","))
    except (ValueError, IndexError):
        return None
    return values if all(map(isfinite, values)) else None


def parameter_axis(text: str, known: Sequence[str]) -> tuple[str, tuple[float, ...]]:
    """Read the axis of a parameter."""
    key, equals, axis = text.partition("=")
    if not equals:
        raise InputError(f"--parameter {shown(text)} is no axis, which is written KEY=LOW:HIGH:COUNT")
    if key not in known:
        raise InputError(
            f"--parameter {one_line(text)}: '{one_line(key)}' is no parameter of a map, the nearest is "
            f"'{nearest(key, known)}'"
        )
    try:
        return key, axis_within(-1e9, 1e9)(axis)
    except InputError as error:
        raise InputError(f"--parameter {one_line(text)}: {error}") from error
