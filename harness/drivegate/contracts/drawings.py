"""How figures show numbers: panels with the columns of a run, and the kinds of figures of a comparison."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeAlias

if TYPE_CHECKING:
    from pandas import DataFrame, Series

Values: TypeAlias = "str | Callable[[DataFrame], Series[float]]"
"""A column of a table, or what is computed from its columns."""


def column_of(table: DataFrame, values: Values) -> Series[float]:
    """Return the values for each row of a table; NaN where one is not known."""
    found: Series[float] = table[values] if isinstance(values, str) else values(table)
    return found.astype(float)


class Line(NamedTuple):
    """A column as a line of a figure."""

    column: str
    name: str
    """Its name in the figure."""
    is_reference: bool = False
    """Whether it is what the drive is asked for or limited by, and is dashed."""
    is_sensed: bool = False
    """Whether it is what the controller saw, and is dotted."""


class Panel(NamedTuple):
    """Lines with a common axis."""

    label: str
    """Quantity and unit."""
    lines: tuple[Line, ...]


TIME: Final = "time_s"
"""Column of the time."""


def panels_for(panels: tuple[Panel, ...], columns: Iterable[str]) -> tuple[Panel, ...]:
    """Return the panels of a contract with what is among the columns; where it states none, one for each column."""
    names = [name for name in columns if name != TIME]
    stated = panels or tuple(Panel(name, (Line(name, name),)) for name in names)
    kept = (Panel(label, tuple(line for line in lines if line.column in names)) for label, lines in stated)
    return tuple(panel for panel in kept if panel.lines)


@dataclass(frozen=True, kw_only=True)
class DifferenceBars:
    """Mean differences from the first candidate, with their intervals."""

    panels: tuple[tuple[str, str, str, str], ...]
    """How `where` begins, and quantity, title and unit of each panel."""
    caption: str
    """Its caption; ``{first}`` stands for the first candidate."""


@dataclass(frozen=True, kw_only=True)
class SpeedCurves:
    """Figures of operating points over speed, at a medium and at the heaviest load."""

    title: str
    panels: tuple[tuple[str, str, str], ...]
    """Key and label of each panel, and the key of the best possible; empty for none."""
    caption: str
    """Its caption; ``{light}`` and ``{heavy}`` stand for the loads (%)."""


@dataclass(frozen=True, kw_only=True)
class SpeedLoadMap:
    """A figure of operating points over speed and torque, in a map for each candidate."""

    key: str
    title: str
    caption: str
    scale: str
    digits: int = 1


@dataclass(frozen=True, kw_only=True)
class RunCurves:
    """What follows a change, over time, in a drawing for each of some runs."""

    most: int
    panels: tuple[tuple[str, str], ...]
    """Key and label of each panel; the first is an error."""
    caption: str
    """Its caption; ``{change_s}`` and ``{held_rpm}`` stand for time of the change (s) and limit of the error (rpm)."""


@dataclass(frozen=True, kw_only=True)
class CycleCurves:
    """Speed and energy over a drive cycle."""

    title: str
    caption: str
    """Its caption; ``{first}`` stands for the first candidate."""


@dataclass(frozen=True)
class MarkPanel:
    """A panel with a mark for each candidate and row."""

    label: str
    """Its axis."""
    values: Values
    """What is drawn."""
    limit: Callable[[Mapping[str, Any]], float] | None = None
    """From the document, return a limit to be drawn."""


@dataclass(frozen=True, kw_only=True)
class RowMarks:
    """Rows of a table by speed and load, with a mark for each candidate."""

    name: str
    title: str
    caption: str
    table: str
    """The table; of operating points, those that are held are drawn."""
    load: str
    """Key of the load."""
    load_label: str
    """What it is called, with its unit."""
    panels: tuple[MarkPanel, ...]


Drawing: TypeAlias = DifferenceBars | SpeedCurves | SpeedLoadMap | RunCurves | CycleCurves | RowMarks
"""Any of them."""
