"""Stretches of a run in which a condition holds."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray


def stretches(inside: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """Go through the stretches that are inside, as their first place and the one after their last."""
    edges = np.flatnonzero(np.diff(inside.astype(np.int8), prepend=0, append=0))
    yield from ((int(first), int(last)) for first, last in zip(edges[::2], edges[1::2], strict=True))


def lasting_from(inside: NDArray[np.bool_]) -> int:
    """Return the first place from which all are inside, the number of places where the last one is not."""
    outside = np.flatnonzero(~inside)
    return int(outside[-1]) + 1 if outside.size else 0
