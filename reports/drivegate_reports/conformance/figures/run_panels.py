"""Panels of signals over the time of a run, one below the other, with room for labels behind its end."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from drivegate_reports.page.style import LEFT, RIGHT, leave_room_for_labels, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LABELS_AT: Final = 1.012
"""Where labels of lines begin, over the end of the run (1)."""


@dataclass
class _Reused:
    """Panels that are drawn on again; most of the time of a figure is that of making its ticks."""

    is_on: bool = False
    panels: tuple[Figure, list[Axes]] | None = None


_REUSED: Final = _Reused()


@contextmanager
def reused_run_panels() -> Iterator[None]:
    """Draw all runs on the same panels; a figure then lasts until the next one is drawn."""
    _REUSED.is_on = True
    try:
        yield
    finally:
        _REUSED.is_on, _REUSED.panels = False, None


def new_run_panels() -> tuple[Figure, list[Axes]]:
    """Make the four panels; in `house_style`."""
    if _REUSED.panels is not None:
        _REUSED.panels[0].subplots_adjust(left=LEFT, right=RIGHT)
        for panel in _REUSED.panels[1]:
            _empty(panel)
        return _REUSED.panels
    made = new_figure(5.6, 4, fitted=False, apart=0.16)
    _REUSED.panels = made if _REUSED.is_on else None
    return made


def _empty(panel: Axes) -> None:
    """Remove what was drawn, and let limits and ticks follow from what will be."""
    from matplotlib import rcParams
    from matplotlib.ticker import AutoLocator, ScalarFormatter

    for artist in (*panel.lines, *panel.texts, *panel.patches):
        artist.remove()
    panel.relim()
    panel.xaxis.set_major_locator(AutoLocator())
    panel.xaxis.set_major_formatter(ScalarFormatter())
    panel.margins(rcParams["axes.xmargin"], rcParams["axes.ymargin"])
    panel.autoscale(True)


def finish_run_panels(panels: list[Axes], end_s: float) -> None:
    for panel in panels[:-1]:
        panel.tick_params(labelbottom=False)
    for panel in panels:
        leave_room_for_labels(panel, end_s)
        panel.ticklabel_format(axis="y", useOffset=False)
        panel.margins(y=0.1)
    panels[-1].set_xlabel("time (s)")
