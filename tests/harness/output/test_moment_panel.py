"""The panel of a deciding moment: its limit, its times and what was measured stand in it, and nothing outside of it."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from drivegate.checks.margin import Mark, Moment, Point
from drivegate.contracts.duty.columns import DutyColumns
from drivegate.output.panels import draw_moment

TIME = np.arange(20_000) * 1e-4
COLUMNS = {"time_s": TIME, "torque_nm": np.where(TIME < 1.0, 0.5, 1.0)}


def test_limit_time_and_measured_value_are_named() -> None:
    moment = Moment(
        start_s=0.999,
        end_s=1.003,
        column="torque_nm",
        origin_s=1.0,
        levels=(Mark(words="reference", value=1.0), Mark(words="90 %", value=0.95)),
        instants=(Mark(words="0.61 ms allowed", value=1.00061),),
        point=Point(words="0.95 ms", time_s=1.00095, value=0.95),
    )
    axes = Figure().subplots()
    draw_moment(axes, moment, COLUMNS, DutyColumns.panels)
    words = {text.get_text() for text in axes.texts}
    assert words == {"reference", "90 %: measured 0.95 ms", "0.61 ms allowed"}
    assert axes.get_xlabel() == "time after 1 s (ms)"
    assert axes.get_ylabel() == "torque (N·m)"
    shown = axes.lines[0].get_xdata()
    assert -1.01 <= min(shown) < max(shown) <= 3.01, "milliseconds around the step alone"
    assert len(shown) == pytest.approx(40, abs=2), "every control period"
