"""Torque ripple over the whole range of speeds (paper, Fig. 6 and its statement of the worst case)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_lab.paper.drives import HIGHEST_PUBLISHED_RPM, banded_drive, ideal_drive, reference_drive
from drivegate_lab.paper.figures.input_current import input_current_sweep
from drivegate_lab.paper.figures.instantaneous_torque import LIMIT_PERCENT, torque_cycle
from drivegate_models.steady.oracle import TorquePoint, point_at_torque
from drivegate_models.steady.steady_state import steady_state
from drivegate_models.units import RADIANS_PER_RPM
from drivegate_reports.page.style import BLUE, GREY, SKY, VERMILION, label, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SLOW_SPEEDS_RPM: Final = tuple(range(50, 500, 25))
"""Speeds below base speed."""


@dataclass(frozen=True)
class RippleOverSpeed:
    """Torque ripple, peak to peak over mean, in the steady state."""

    slow_rpm: NDArray[np.float64]
    slow_percent: NDArray[np.float64]
    """Below base speed, at 0° and the current limit: speed (rpm), ripple with ideal regulators (%), shape
    (k,)."""
    speed_rpm: NDArray[np.float64]
    """Speeds of constant power (rpm), shape (n,)."""
    initial_percent: NDArray[np.float64]
    optimal_percent: NDArray[np.float64]
    """Ripple with ideal regulators at the initial angle and at the angle of least Σ|i| (%), shape (n,)."""
    banded_percent: NDArray[np.float64]
    """Ripple with the hysteresis band at the latter (%); NaN where the band puts the torque out of reach,
    shape (n,)."""
    published_rpm: float
    published_deg: float
    published_percent: float
    """Speed and angle at the torque of Fig. 6, and the ripple there (%)."""


def _percent(lowest: float, highest: float, mean: float) -> float:
    return 100.0 * (highest - lowest) / mean


def _slow(speed_rpm: float) -> float:
    state = steady_state(
        ideal_drive(), speed_rpm * RADIANS_PER_RPM, reference_drive().rating.current_limit_a, 0.0
    )
    return _percent(state.torque_lowest, state.torque_highest, state.torque)


def _banded(speed_rpm: float, advance_deg: float, power_w: float) -> float:
    speed = speed_rpm * RADIANS_PER_RPM
    found: TorquePoint = point_at_torque(banded_drive(), speed, math.radians(advance_deg), power_w / speed)
    return _percent(found.torque_lowest, found.torque_highest, found.torque)


@cache
def ripple_over_speed() -> RippleOverSpeed:
    """Compute the ripple at constant power and below base speed."""
    sweep = input_current_sweep()
    cycle = torque_cycle()
    banded = [
        _banded(speed, angle, sweep.power_w)
        for speed, angle in zip(sweep.speed_rpm, sweep.optimal_deg, strict=True)
    ]
    return RippleOverSpeed(
        slow_rpm=np.array(SLOW_SPEEDS_RPM, dtype=np.float64),
        slow_percent=np.array([_slow(speed) for speed in SLOW_SPEEDS_RPM]),
        speed_rpm=sweep.speed_rpm,
        initial_percent=sweep.initial_ripple_percent,
        optimal_percent=sweep.optimal_ripple_percent,
        banded_percent=np.array(banded),
        published_rpm=cycle.speed_rpm,
        published_deg=cycle.advance_deg,
        published_percent=cycle.ripple_percent,
    )


TITLE = "Torque ripple over the range of speeds (on Fig. 6)"


def alternative(data: RippleOverSpeed) -> str:
    """Describe the figure in words, for who cannot see it."""
    worst = int(np.argmax(data.optimal_percent))
    return (
        "With ideal regulators the ripple at the angle of least current lies between "
        f"{data.optimal_percent.min():.1f} "
        f"and {data.optimal_percent[worst]:.1f} %, the greatest at {data.speed_rpm[worst]:.0f} rpm; at the initial "
        f"angle it is at most {data.initial_percent.max():.1f} %. The published limit of "
        f"{LIMIT_PERCENT:.0f} % is a level "
        f"line. Below base speed, at 0° and the current limit, it is at most {data.slow_percent.max():.1f} %."
    )


def caption(data: RippleOverSpeed) -> str:
    """State what the figure shows."""
    above = data.speed_rpm[
        (data.optimal_percent >= LIMIT_PERCENT) & (data.speed_rpm <= HIGHEST_PUBLISHED_RPM)
    ]
    course = (
        f"passes the limit at {', '.join(f'{speed:.0f}' for speed in above)} rpm"
        if above.size
        else "stays below it"
    )
    return (
        "Steady states of 1.5 kW; below base speed at 0° and 26 A. At the angle of least Σ|i|, on the edge "
        "of what is "
        f"feasible, the ripple {course}; at 9.8 N·m and {data.published_deg:g}° it is "
        f"{data.published_percent:.1f} %. With "
        "the hysteresis band the torque jumps near that edge, and both sides of a jump count. Where the "
        "line of the band "
        "is missing, the band puts the torque just out of reach at that angle."
    )


def draw(data: RippleOverSpeed) -> Figure:
    """Draw the ripple over speed."""
    figure, (panel,) = new_figure(4.0, 1)
    panel.axhline(LIMIT_PERCENT, color=GREY, linewidth=1.0, linestyle=(0, (4, 3)))
    label(panel, 30.0, LIMIT_PERCENT + 0.3, f"published: below {LIMIT_PERCENT:.0f} %", GREY, va="bottom")
    panel.plot(data.slow_rpm, data.slow_percent, color=GREY)
    peak = int(np.argmax(data.slow_percent))
    label(panel, data.slow_rpm[peak] + 70.0, 0.8 * data.slow_percent[peak], "0°, 26 A", GREY, va="center")
    panel.plot(data.speed_rpm, data.banded_percent, color=SKY, linewidth=1.0, marker=".", markersize=4)
    panel.plot(data.speed_rpm, data.initial_percent, color=VERMILION)
    panel.plot(data.speed_rpm, data.optimal_percent, color=BLUE)
    end = float(data.speed_rpm[-1]) + 20.0
    label(panel, end, data.initial_percent[-1], "initial angle", VERMILION, va="center")
    label(panel, end, data.optimal_percent[-1], "least Σ|i|", BLUE, va="center", weight="bold")
    known = np.flatnonzero(np.isfinite(data.banded_percent))
    if known.size:
        last = int(known[-1])
        text = "least Σ|i|,\nwith the band"
        label(panel, data.speed_rpm[last] + 20.0, data.banded_percent[last] + 0.8, text, SKY, va="bottom")
    panel.plot([data.published_rpm], [data.published_percent], color="black", marker="o", markersize=5)
    panel.text(data.published_rpm + 25.0, data.published_percent, "Fig. 6", fontsize=9.0, va="center")
    panel.set_xlim(0.0, 2420.0)
    panel.set_ylim(bottom=0.0)
    panel.set_xticks(np.arange(0.0, 2001.0, 250.0))
    panel.set_xlabel("speed (rpm)")
    panel.set_ylabel("torque ripple, peak to peak over mean (%)")
    return figure
