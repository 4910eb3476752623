"""How figures show the columns of a run: panels of lines."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final, NamedTuple


class Line(NamedTuple):
    """A column as a line of a figure."""

    column: str
    """Its name."""
    name: str
    """Its name in the figure."""
    is_reference: bool = False
    """Whether it is what the drive is asked for or limited by, and is dashed."""


class Panel(NamedTuple):
    """Lines with a common axis."""

    label: str
    """Quantity and unit."""
    lines: tuple[Line, ...]
    """The lines."""


TIME: Final = "time_s"
"""Column of the time."""


def panels_for(panels: tuple[Panel, ...], columns: Iterable[str]) -> tuple[Panel, ...]:
    """Return the panels of a contract with what is among the columns; where it states none, one for each column."""
    names = [name for name in columns if name != TIME]
    stated = panels or tuple(Panel(name, (Line(name, name),)) for name in names)
    kept = (Panel(label, tuple(line for line in lines if line.column in names)) for label, lines in stated)
    return tuple(panel for panel in kept if panel.lines)
