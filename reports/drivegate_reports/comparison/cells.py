"""Cells and tables of the comparison page, and how names and numbers are written in them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from drivegate.contracts.comparison import Column, Words
from drivegate_cases.documents import wording
from drivegate_reports.page.page import clean

_LONGEST_NAME: Final = 80


@dataclass(frozen=True)
class Cell:
    """A cell of a table."""

    text: str
    """What is shown."""
    tone: str = ""
    """``pass``, ``caution``, ``fail`` or empty."""
    is_number: bool = False
    """Whether it is aligned as one."""
    sort: str = ""
    """What it is sorted by, where that is not the text."""


@dataclass(frozen=True)
class Sheet:
    """A table."""

    name: str
    """Name of its CSV file and of its place in the page."""
    caption: str
    """What it shows."""
    heads: tuple[str, ...]
    """Headings, with units."""
    rows: tuple[tuple[Cell, ...], ...]
    """The first cell of each names the row."""


def sheet_of(
    table: str, caption: str, columns: Sequence[Column], rows: Iterable[Mapping[str, Any]], first: str = ""
) -> Sheet:
    """Write the columns of rows; `first` is the first candidate of the ranking, which a heading may name."""
    heads = tuple(column.heading.replace("{first}", first) for column in columns)
    return Sheet(
        table, caption, heads, tuple(tuple(cell_of(column, row) for column in columns) for row in rows)
    )


def cell_of(column: Column, row: Mapping[str, Any]) -> Cell:
    """Write a column of a row."""
    if isinstance(column, Words):
        text, tone = column.write(dict(row)), column.tone(dict(row))
        return Cell(clean(text, column.longest), tone, is_number=text[:1].isdigit())
    if column.digits is None:
        return absolute(row[column.name])
    return figure(row[column.name], column.digits, signed=column.signed)


def name(value: object) -> str:
    """Make a candidate's name printable and short enough for a heading."""
    return clean(value, _LONGEST_NAME)


def figure(value: float | None, digits: int, *, signed: bool = False) -> Cell:
    """Write a number as a cell."""
    sort = "" if value is not None else "1e99"
    return Cell(written(value, digits, signed=signed), is_number=True, sort=sort)


def absolute(value: float | None) -> Cell:
    """Write a number of a machine of any size as a cell, to four digits."""
    if value is None:
        return figure(None, 0)
    return Cell(wording.figure(value).replace("-", "−"), is_number=True, sort=f"{value:.9g}")


def written(value: float | None, digits: int, *, signed: bool = False) -> str:
    """Write a number."""
    if value is None:
        return "–"
    text = f"{value:+.{digits}f}" if signed else f"{value:.{digits}f}"
    if float(text) == 0.0:
        text = text.lstrip("+-")
    return text.replace("-", "−")
