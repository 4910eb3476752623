"""The search for the optimal angle, over time and in the plane of current sum over angle (paper, Fig. 5)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.builtin.loading import BuiltinController
from drivegate.drives.running import run_scenario
from drivegate_cases.scenario.load import ConstantTorqueLoad
from drivegate_cases.scenario.scenario import Scenario, load_scenario
from drivegate_lab.paper.drives import banded_drive
from drivegate_models.controllers.current.builtin import SEARCH_PERIOD, SEARCHES
from drivegate_models.loop.observation import TRACE_COLUMNS
from drivegate_models.steady.oracle import current_sum_curve, least_current_sum
from drivegate_models.units import RADIANS_PER_RPM
from drivegate_reports.page.style import BLUE, GREEN, GREY, VERMILION, label, new_figure, signed

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SCENARIO = "fig5-search"
COLOURS = {"reference": BLUE, "published": VERMILION}
LOADING_TIME = 0.6
"""Time after the load comes on that the plane leaves out, while the speed recovers (s)."""
_CURVE_DEG = np.arange(47.0, 63.01, 0.25)


@dataclass(frozen=True)
class SearchRun:
    """One controller's search, as means over each of its decision periods."""

    name: str
    """The controller."""
    time_s: NDArray[np.float64]
    """End of each decision period (s), shape (n,)."""
    advance_deg: NDArray[np.float64]
    """Advance angle in it (electrical deg), shape (n,)."""
    current_sum_a: NDArray[np.float64]
    """Mean sum of current magnitudes (A), shape (n,)."""
    speed_error_rpm: NDArray[np.float64]
    """Mean of true speed minus reference (rpm), shape (n,)."""
    current_reference_a: NDArray[np.float64]
    """Mean current reference (A), shape (n,)."""


@dataclass(frozen=True)
class SearchTrajectory:
    """The searches of two controllers, and the curve on which they look for the minimum."""

    reference: SearchRun
    published: SearchRun
    """The guarded search, and Fig. 4 taken literally."""
    speed_rpm: float
    torque_nm: float
    current_limit_a: float
    load_begins_s: float
    """Operating point, limit of the current reference, and when the load comes on."""
    curve_advance_deg: NDArray[np.float64]
    """Angles of the curve (electrical deg), shape (k,)."""
    curve_current_sum_a: NDArray[np.float64]
    """Sum of current magnitudes in the steady state (A); NaN where the torque is out of reach, shape (k,)."""
    optimum_deg: float
    optimum_current_sum_a: float
    """The least of the curve."""


def _search_run(name: str, scenario: Scenario) -> SearchRun:
    run = run_scenario(scenario, BuiltinController(SEARCHES[name]), trace_every=1)
    block = round(SEARCH_PERIOD / scenario.control_period_s)
    blocks = run.trace.shape[0] // block
    kept = run.trace[: blocks * block].reshape(blocks, block)
    column = {key: kept[key].mean(axis=1) for key in TRACE_COLUMNS}
    return SearchRun(
        name=name,
        time_s=(np.arange(blocks) + 1.0) * block * scenario.control_period_s,
        advance_deg=column["advance_deg"],
        current_sum_a=column["current_sum_a"],
        speed_error_rpm=column["speed_rpm"] - column["speed_reference_rpm"],
        current_reference_a=column["current_reference_a"],
    )


@cache
def search_trajectory() -> SearchTrajectory:
    """Run the searches at 1500 rpm and 9.8 N·m."""
    scenario = load_scenario(SCENARIO)
    load = scenario.load
    assert isinstance(load, ConstantTorqueLoad), f"the scenario {SCENARIO} has a load of constant torque"
    speed = scenario.speed_rpm[0][1]
    drive = banded_drive()
    curve = current_sum_curve(drive, speed * RADIANS_PER_RPM, load.torque_nm, np.radians(_CURVE_DEG))
    least = least_current_sum(drive, speed * RADIANS_PER_RPM, load.torque_nm)
    return SearchTrajectory(
        reference=_search_run("reference", scenario),
        published=_search_run("published", scenario),
        speed_rpm=speed,
        torque_nm=load.torque_nm,
        current_limit_a=scenario.drive.rating.current_limit_a,
        load_begins_s=load.factor[-1][0],
        curve_advance_deg=_CURVE_DEG,
        curve_current_sum_a=curve.current_sum,
        optimum_deg=float(np.degrees(least.advance)),
        optimum_current_sum_a=least.current_sum,
    )


TITLE = "Search for the optimal angle (Fig. 5)"


def alternative(data: SearchTrajectory) -> str:
    """Describe the figure in words, for who cannot see it."""
    kept, lost = data.reference, data.published
    return (
        f"The reference's advance angle goes from {kept.advance_deg[0]:.0f}° to {kept.advance_deg[-1]:.1f}° and stays; "
        f"its speed error stays near zero. The published flowchart goes on past {data.optimum_deg:.1f}°, ends at "
        f"{lost.advance_deg[-1]:.0f}° and {signed(lost.speed_error_rpm[-1], 0)} rpm with the speed regulator saturated."
    )


def caption(data: SearchTrajectory) -> str:
    """State what the figure shows."""
    return (
        f"Closed loop at {data.speed_rpm:.0f} rpm and {data.torque_nm:g} N·m, means over each 100 ms of the search. "
        f"The least Σ|i| lies on the feasible edge, {data.optimum_deg:.1f}°. `reference` stops next to it at "
        f"{data.reference.advance_deg[-1]:.1f}°. `published`, Fig. 4 taken literally, steps over the edge: the "
        "torque is out of reach, the speed falls, the search freezes since the error exceeds k1, and nothing brings "
        "it back; its angle keeps falling only because Fig. 3's line follows the speed. Its smaller Σ|i| is no "
        "saving: the speed is not held."
    )


def draw(data: SearchTrajectory) -> Figure:
    """Draw angle and speed error over time, and the search in the plane of current sum over angle."""
    figure, panels = new_figure(7.6, 3, (1.0, 0.8, 1.25))
    _draw_angles(panels[0], data)
    _draw_errors(panels[1], data)
    _draw_plane(panels[2], data)
    return figure


def _draw_angles(panel: Axes, data: SearchTrajectory) -> None:
    end = data.reference.time_s[-1]
    for run, offset, side in ((data.reference, 0.6, "bottom"), (data.published, 0.8, "bottom")):
        panel.step(run.time_s, run.advance_deg, where="post", color=COLOURS[run.name])
        level = run.advance_deg[-1] + offset
        label(panel, end, level, run.name, COLOURS[run.name], ha="right", va=side, weight="bold")
    panel.axhline(data.optimum_deg, color=GREY, linewidth=1.0, linestyle=(0, (4, 3)))
    text = f"least Σ|i| in the steady state: {data.optimum_deg:.1f}°"
    label(panel, end, data.optimum_deg - 0.8, text, GREY, ha="right", va="top")
    panel.set_ylabel("advance angle (el. deg)")
    panel.set_xlabel("time (s)")
    panel.margins(x=0.01, y=0.12)


def _draw_errors(panel: Axes, data: SearchTrajectory) -> None:
    for run in (data.reference, data.published):
        panel.plot(run.time_s, run.speed_error_rpm, color=COLOURS[run.name])
    lost = data.published
    height = 0.05 * float(np.ptp(lost.speed_error_rpm))
    label(panel, lost.time_s[-1], -height, "reference", BLUE, ha="right", va="top", weight="bold")
    text = f"published: {signed(lost.speed_error_rpm[-1], 0)} rpm, regulator saturated at {data.current_limit_a:.0f} A"
    level = lost.speed_error_rpm[-1] + 2.5 * height
    label(panel, lost.time_s[-1], level, text, VERMILION, ha="right", va="bottom", weight="bold")
    panel.set_ylabel("speed error (rpm)")
    panel.set_xlabel("time (s)")
    panel.margins(x=0.01, y=0.18)


def _draw_plane(panel: Axes, data: SearchTrajectory) -> None:
    panel.plot(data.curve_advance_deg, data.curve_current_sum_a, color=GREY, linewidth=5.0, alpha=0.45)
    text = f"steady state at {data.torque_nm:g} N·m"
    last = data.curve_current_sum_a[-1]
    label(panel, data.curve_advance_deg[-1] - 1.6, last, text, GREY, ha="right", va="center")
    for run, marker in ((data.published, "s"), (data.reference, "o")):
        searching = run.time_s > data.load_begins_s + LOADING_TIME
        panel.plot(
            run.advance_deg[searching],
            run.current_sum_a[searching],
            color=COLOURS[run.name],
            marker=marker,
            markersize=3.2,
            linewidth=1.0,
        )
    lost = data.published
    text = "published: over the edge, speed lost, frozen"
    at = (data.curve_advance_deg[-1], lost.current_sum_a[-1] + 1.5)
    label(panel, *at, text, VERMILION, ha="right", weight="bold")
    end = data.reference
    at = (end.advance_deg[-1] + 0.8, end.current_sum_a[-1] - 0.4)
    label(panel, *at, "reference", BLUE, va="top", weight="bold")
    panel.plot([data.optimum_deg], [data.optimum_current_sum_a], marker="*", color=GREEN, markersize=12)
    text = "least Σ|i|, on the feasible edge"
    at = (data.optimum_deg - 0.6, data.optimum_current_sum_a + 0.5)
    label(panel, *at, text, GREEN, ha="right", va="bottom")
    panel.set_xlabel("advance angle (el. deg)")
    panel.set_ylabel("Σ|i| (A)")
    panel.margins(x=0.03, y=0.12)
