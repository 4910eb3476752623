"""A margin: how far a run is from a check's limit, normalised to it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

GREATEST: Final = 1e12
"""Greatest size of a margin: beyond it a miss shows nothing more, and sums and means of margins stay finite."""
GREATEST_SHOWN: Final = 10.0
"""Greatest size of a margin that people are shown."""
_LEAST: Final = math.ulp(0.0)


@dataclass(frozen=True)
class Margin:
    """What one check says of one run."""

    check: str
    """Identifier of the check."""
    value: float
    """Distance from the limit over the limit: positive or zero when the requirement is met, negative when
    not; within `GREATEST` of zero."""
    measured: str
    """The measured quantity in people's units."""
    advisory: bool = False
    """Whether the run lies where the check only advises."""

    @property
    def met(self) -> bool:
        """Whether the requirement is met."""
        return self.value >= 0.0


def margin_in_words(value: float, digits: int = 3) -> str:
    """Write a margin for people: beyond 10 limits its size says nothing more, and is written as that."""
    bound = min(max(value, -GREATEST_SHOWN), GREATEST_SHOWN)
    return f"{'beyond ' if bound != value else ''}{bound:+.{digits}g}"


def normalised(distance: float, limit: float) -> float:
    """Return a distance from a limit as a share of it, without losing its sign."""
    if math.isnan(distance):
        return -GREATEST
    # A share of next to nothing, such as the current of an extreme command, may be no number any more.
    share = distance / limit if limit != 0.0 else math.copysign(GREATEST, distance) if distance else 0.0
    return min(share, GREATEST) if distance >= 0.0 else max(min(share, -_LEAST), -GREATEST)


def at_most(measured: float, limit: float) -> float:
    """Judge a quantity that may be as large as its limit."""
    return normalised(limit - measured, limit)


def below(measured: float, limit: float) -> float:
    """Judge a quantity that has to stay below its limit."""
    return at_most(measured, limit) if measured != limit else -_LEAST


def worst_required(margins: Sequence[Margin]) -> Margin | None:
    """Return the least margin of those that are required, or of those that only advise where there are no others."""
    required = [margin for margin in margins if not margin.advisory]
    return min(required or margins, key=lambda margin: margin.value, default=None)
