"""A margin: how far a run is from a check's limit, normalized to it, and the stretch of the run that decides it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from pydantic import Field

from drivegate_cases.documents.document import Section

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
    is_timed: bool = False
    """Whether it depends on the machine that checks."""

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


class Mark(Section):
    """A value with the words for it."""

    words: str = Field(description="what the value is, with its unit")
    value: float = Field(description="the value")


class Point(Section):
    """What was measured, where it was measured."""

    words: str = Field(description="the measured quantity, with its unit")
    time_s: float = Field(description="when, in seconds")
    value: float = Field(description="value of the column there")


class Course(Section):
    """A quantity over time that no recorded column has."""

    words: str = Field(description="what it is")
    time_s: tuple[float, ...] = Field(description="times, in seconds")
    values: tuple[float, ...] = Field(description="its value at each of them")


class Moment(Section):
    """The stretch of a run that decides a margin, and the recorded column or the courses that show it."""

    start_s: float = Field(description="start of the stretch, in seconds")
    end_s: float = Field(description="end of it, in seconds")
    column: str = Field(
        default="", description="recorded column that decides; empty where no single one does"
    )
    quantity: str = Field(default="", description="what the courses are, with its unit; empty without any")
    courses: tuple[Course, ...] = Field(
        default=(), description="the quantity that decides, where no recorded column has it"
    )
    origin_s: float | None = Field(
        default=None, description="time of the step or failure that it follows, in seconds"
    )
    levels: tuple[Mark, ...] = Field(default=(), description="references and limits, as values of the column")
    instants: tuple[Mark, ...] = Field(default=(), description="times that matter, in seconds")
    point: Point | None = Field(default=None, description="the measured value")

    @property
    def is_marked(self) -> bool:
        """Whether it shows the quantity that decides."""
        return bool(self.column or self.courses)
