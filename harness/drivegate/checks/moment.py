"""The stretch of a run that decides a margin, and what a figure marks in it."""

from __future__ import annotations

from pydantic import Field

from drivegate_cases.documents.document import Section


class Mark(Section):
    """A value with the words for it."""

    words: str = Field(description="what the value is, with its unit")
    value: float = Field(description="the value")


class Point(Section):
    """What was measured, where it was measured."""

    words: str = Field(description="the measured quantity, with its unit")
    time_s: float = Field(description="when, in seconds")
    value: float = Field(description="value of the column there")


class Moment(Section):
    """The stretch of a run that decides a margin; a check that knows more than the stretch states its column."""

    start_s: float = Field(description="start of the stretch, in seconds")
    end_s: float = Field(description="end of it, in seconds")
    column: str = Field(
        default="", description="recorded column that decides; empty where no single one does"
    )
    origin_s: float | None = Field(
        default=None, description="time of the step or failure that it follows, in seconds"
    )
    levels: tuple[Mark, ...] = Field(default=(), description="references and limits, as values of the column")
    instants: tuple[Mark, ...] = Field(default=(), description="times that matter, in seconds")
    point: Point | None = Field(default=None, description="the measured value")
