"""A figure of the paper, ready to be placed in a page."""

from __future__ import annotations

from functools import cache

from drivegate_reports.page.figure import PageFigure
from drivegate_reports.page.style import house_style, inline_svg
from drivegate_reports.paper.catalogue import PaperFigure


@cache
def placed(figure: PaperFigure) -> PageFigure:
    """Compute and draw a figure."""
    data = figure.compute()
    identifier = f"figure-{figure.name}"
    with house_style():
        svg = inline_svg(figure.draw(data), identifier)
    return PageFigure(identifier, figure.title, svg, figure.alternative(data), figure.caption(data))
