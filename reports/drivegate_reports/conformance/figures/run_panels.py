"""Panels of signals over the time of a run, one below the other, with room for labels behind its end."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from drivegate_reports.page.style import new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LABELS_AT: Final = 1.012
"""Where labels of lines begin, over the end of the run (1)."""
_WITH_LABELS: Final = 1.2


def new_run_panels() -> tuple[Figure, list[Axes]]:
    """Make the four panels; in `house_style`."""
    return new_figure(5.6, 4, fitted=False, apart=0.16)


def finish_run_panels(panels: list[Axes], end_s: float) -> None:
    """Give drawn panels the same axis of time."""
    for panel in panels[:-1]:
        panel.tick_params(labelbottom=False)
    for panel in panels:
        panel.set_xlim(0.0, _WITH_LABELS * end_s)
        panel.set_xticks([tick for tick in panel.get_xticks() if 0.0 <= tick <= 1.001 * end_s])
        panel.ticklabel_format(axis="y", useOffset=False)
        panel.margins(y=0.1)
    panels[-1].set_xlabel("time (s)")
