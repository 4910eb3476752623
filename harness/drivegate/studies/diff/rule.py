"""When two commands count as different."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

BITWISE: Final = -1.0
"""The tolerance that leaves no bit free."""


@dataclass(frozen=True)
class Rule:
    """When two commands count as different."""

    tolerance: float = BITWISE
    """Greatest difference of a number, relative to the larger one, absolute where that is below 1; `BITWISE`
    for none."""
    ignored: tuple[str, ...] = ()
    """The fields that are not compared."""

    def judged(self, fields: Iterable[str]) -> tuple[str, ...]:
        """Return the fields that are compared."""
        return tuple(name for name in fields if name not in self.ignored)


def first_difference(commands: NDArray[Any], answers: NDArray[Any], rule: Rule) -> int | None:
    """Find the first answer that differs from a command in a field that is judged; None where none does."""
    found = np.zeros(len(answers), np.bool_)
    # The first field is the size of the record.
    for name in rule.judged((commands.dtype.names or ())[1:]):
        found |= differing(commands[name][: len(answers)], answers[name], rule.tolerance)
    return int(np.argmax(found)) if found.any() else None


def differing(one: NDArray[Any], other: NDArray[Any], tolerance: float) -> NDArray[np.bool_]:
    """Return of each pair of numbers whether they differ: by any bit, or by more than a tolerance.

    Two NaN do not differ; whole numbers do by any difference.
    """
    apart: NDArray[np.bool_]
    if one.dtype.kind != "f":
        apart = one != other
        return apart
    if tolerance < 0.0:
        apart = one.view(np.int64) != other.view(np.int64)
    else:
        # The difference of two infinite numbers is none.
        with np.errstate(invalid="ignore", over="ignore"):
            largest = np.maximum(1.0, np.maximum(np.abs(one), np.abs(other)))
            apart = np.abs(one - other) > tolerance * largest
    nan, other_nan = np.isnan(one), np.isnan(other)
    either = nan | other_nan
    apart[either] = (nan != other_nan)[either]
    return apart
