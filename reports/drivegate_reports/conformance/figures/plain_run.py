"""The recorded columns of a run over time, one panel each, of a contract that has no drawing of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from drivegate.contracts.contract import RecordedTrace
from drivegate_reports.page.style import BLUE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CAPTION: Final = "Means over equal stretches of the run."
_TIME: Final = "time_s"


def alternative(trace: RecordedTrace) -> str:
    ends = (f"{name} ends at {values[-1]:.5g}" for name, values in trace.columns.items() if name != _TIME)
    return f"Over {trace.scenario.duration_s:g} s, {', '.join(ends)}."


def draw(trace: RecordedTrace) -> Figure:
    from matplotlib.figure import Figure

    columns = {name: values for name, values in trace.columns.items() if name != _TIME}
    figure = Figure(figsize=(9.0, 1.9 * len(columns)), layout="constrained")
    panels = figure.subplots(len(columns), 1, sharex=True, squeeze=False)[:, 0]
    for panel, (name, values) in zip(panels, columns.items(), strict=True):
        panel.plot(trace.columns[_TIME], values, color=BLUE, linewidth=1.3)
        panel.set_ylabel(name)
    panels[-1].set_xlabel("time (s)")
    return figure
