"""A figure as a page places it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from drivegate_reports.page.style import house_style, inline_svg

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class PageFigure:
    """A figure with its words."""

    name: str
    """Unique in the page."""
    title: str
    """What it is about."""
    svg: str
    """The ``svg`` element."""
    alternative: str
    """The figure in words."""
    caption: str
    """What it shows and under which conditions."""


def page_figure(
    name: str, title: str, draw: Callable[[], Figure], alternative: str, caption: str
) -> PageFigure:
    """Draw a figure for a page."""
    with house_style():
        svg = inline_svg(draw(), name)
    return PageFigure(name, title, svg, alternative, caption)
