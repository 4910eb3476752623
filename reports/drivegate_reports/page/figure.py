"""A figure as a page places it."""

from __future__ import annotations

from dataclasses import dataclass


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
