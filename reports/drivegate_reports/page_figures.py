"""The figures of the conformance page, ready to be placed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from drivegate_reports.figures import input_current, instantaneous_torque, phase_currents, search_trajectory
from drivegate_reports.style import house_style, inline_svg

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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


@cache
def page_figures() -> tuple[PageFigure, ...]:
    """Compute and draw the figures.

    Returns
    -------
    tuple of PageFigure
        In the order of the page.
    """
    trajectory = search_trajectory.search_trajectory()
    torque = instantaneous_torque.torque_cycle()
    sweep = input_current.input_current_sweep()
    currents = tuple(phase_currents.phase_currents(point) for point in phase_currents.POINTS)
    with house_style():
        return (
            _placed(
                "search",
                search_trajectory.TITLE,
                search_trajectory.draw(trajectory),
                search_trajectory.alternative(trajectory),
                search_trajectory.caption(trajectory),
            ),
            _placed(
                "torque",
                instantaneous_torque.TITLE,
                instantaneous_torque.draw(torque),
                instantaneous_torque.alternative(torque),
                instantaneous_torque.caption(torque),
            ),
            _placed(
                "saving",
                input_current.TITLE,
                input_current.draw(sweep),
                input_current.alternative(sweep),
                input_current.caption(sweep),
            ),
            _placed(
                "currents",
                phase_currents.TITLE,
                phase_currents.draw(currents),
                phase_currents.alternative(currents),
                phase_currents.caption(currents),
            ),
        )


def _placed(name: str, title: str, figure: Figure, alternative: str, caption: str) -> PageFigure:
    identifier = f"figure-{name}"
    return PageFigure(identifier, title, inline_svg(figure, identifier), alternative, caption)
