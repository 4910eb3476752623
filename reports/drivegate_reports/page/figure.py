"""A figure as a page places it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PageFigure:
    """A figure with its words.

    Attributes
    ----------
    name : str
        Unique in the page.
    title : str
        What it is about.
    svg : str
        The ``svg`` element.
    alternative : str
        The figure in words.
    caption : str
        What it shows and under which conditions.
    """

    name: str
    title: str
    svg: str
    alternative: str
    caption: str
