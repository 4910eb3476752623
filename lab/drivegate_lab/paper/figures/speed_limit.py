"""Constant power beyond three times base speed, and at 90° (paper, sections Constant Power Operation and Results)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_lab.paper.drives import HIGHEST_PUBLISHED_RPM, ideal_drive, power_torque, reference_drive
from drivegate_models.steady.oracle import feasible_edge
from drivegate_models.steady.steady_state import steady_state
from drivegate_models.units import RADIANS_PER_RPM
from drivegate_reports.page.style import BLUE, GREEN, GREY, VERMILION, label, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FASTEST_RPM: Final = 6000.0
"""Greatest speed of the figure, twelve times base speed."""
_ANGLES_DEG: Final = np.arange(20.0, 90.01, 1.0)


@dataclass(frozen=True)
class SpeedLimit:
    """What the drive can give at the current limit over speed, in the steady state with ideal regulators."""

    rated_power_w: float
    base_speed_rpm: float
    """Rating."""
    speed_rpm: NDArray[np.float64]
    """Speeds (rpm), shape (n,)."""
    edge_deg: NDArray[np.float64]
    """Smallest angle that gives rated power (electrical deg), shape (n,)."""
    best_deg: NDArray[np.float64]
    """Angle of the greatest power, on a grid of 1° (electrical deg), shape (n,)."""
    greatest_power_w: NDArray[np.float64]
    power_at_90_w: NDArray[np.float64]
    """Power there, and at 90° (W), shape (n,)."""

    @property
    def ninety_from_rpm(self) -> float:
        """Speed from which on 90° gives the greatest power; NaN where it never does (rpm)."""
        lower = np.flatnonzero(self.best_deg < 90.0)
        if lower.size == 0:
            return float(self.speed_rpm[0])
        after = int(lower[-1]) + 1
        return float(self.speed_rpm[after]) if after < self.speed_rpm.size else math.nan

    @property
    def reached_rpm(self) -> float:
        """Greatest of the speeds at which rated power is within reach (rpm)."""
        return float(self.speed_rpm[np.isfinite(self.edge_deg)][-1])


@cache
def speed_limit() -> SpeedLimit:
    """Compute what is within reach up to `FASTEST_RPM`."""
    rating, drive = reference_drive().rating, ideal_drive()
    speeds = np.arange(600.0, FASTEST_RPM + 1.0, 200.0)
    edges, best, greatest, ninety = [], [], [], []
    for speed_rpm in speeds:
        speed = speed_rpm * RADIANS_PER_RPM
        powers = [
            speed * steady_state(drive, speed, rating.current_limit_a, angle).torque
            for angle in np.radians(_ANGLES_DEG)
        ]
        at = int(np.argmax(powers))
        edges.append(math.degrees(feasible_edge(drive, speed, power_torque(speed_rpm, rating.rated_power_w))))
        best.append(_ANGLES_DEG[at])
        greatest.append(powers[at])
        ninety.append(powers[-1])
    return SpeedLimit(
        rating.rated_power_w,
        rating.base_speed_rpm,
        speeds,
        *map(np.array, (edges, best, greatest, ninety)),
    )


TITLE = "The limit of speed (on Fig. 10 and section Constant Power Operation)"


def alternative(data: SpeedLimit) -> str:
    """Describe the figure in words, for who cannot see it."""
    return (
        f"Upper panel: the greatest power at the current limit stays above {data.greatest_power_w.min():.0f} W up to "
        f"{data.speed_rpm[-1]:.0f} rpm, the power at 90° comes up to it from below. Lower panel: the angle of greatest "
        f"power rises to 90°, which it has from {data.ninety_from_rpm:.0f} rpm on; the smallest angle for rated power "
        f"rises to {data.edge_deg[-1]:.0f}° only."
    )


def caption(data: SpeedLimit) -> str:
    """State what the figure shows."""
    return (
        f"At 26 A with ideal regulators. Rated power is within reach far beyond three times base speed, at least up to "
        f"{data.reached_rpm:.0f} rpm, {data.reached_rpm / data.base_speed_rpm:.0f} times base speed. From "
        f"{data.ninety_from_rpm:.0f} rpm on no angle gives more power than 90°, as published for the greatest speed; "
        "but this drive, without friction and core loss, shows no greatest speed: its power levels off above 1.5 kW."
    )


def draw(data: SpeedLimit) -> Figure:
    """Draw powers and angles over speed."""
    figure, panels = new_figure(5.6, 2)
    _draw_powers(panels[0], data)
    _draw_angles(panels[1], data)
    for panel in panels:
        panel.axvline(HIGHEST_PUBLISHED_RPM, color=GREY, linewidth=0.8, linestyle=(0, (3, 3)))
        panel.set_xlim(400.0, 7300.0)
        panel.set_xticks(np.arange(1000.0, FASTEST_RPM + 1.0, 1000.0))
        panel.set_xlabel("speed (rpm)")
    label(panels[1], HIGHEST_PUBLISHED_RPM + 40.0, 8.0, "three times\nbase speed", GREY)
    return figure


def _draw_powers(panel: Axes, data: SpeedLimit) -> None:
    panel.axhline(data.rated_power_w, color=GREY, linewidth=1.0, linestyle=(0, (4, 3)))
    panel.plot(data.speed_rpm, data.power_at_90_w, color=VERMILION)
    panel.plot(data.speed_rpm, data.greatest_power_w, color=BLUE)
    end = float(data.speed_rpm[-1]) + 60.0
    label(
        panel,
        1800.0,
        data.greatest_power_w.max() + 20.0,
        "at the best angle",
        BLUE,
        va="bottom",
        weight="bold",
    )
    label(panel, end, data.power_at_90_w[-1], "at 90°", VERMILION, va="center", weight="bold")
    label(panel, end, data.rated_power_w + 10.0, "rated power", GREY, va="bottom")
    panel.set_ylabel("greatest power at 26 A (W)")
    panel.set_ylim(top=data.greatest_power_w.max() + 160.0)


def _draw_angles(panel: Axes, data: SpeedLimit) -> None:
    panel.fill_between(data.speed_rpm, 0.0, data.edge_deg, color=GREY, alpha=0.18, linewidth=0)
    panel.plot(data.speed_rpm, data.best_deg, color=BLUE)
    panel.plot(data.speed_rpm, data.edge_deg, color=GREEN)
    end = float(data.speed_rpm[-1]) + 60.0
    label(panel, end, data.best_deg[-1], "greatest power", BLUE, va="center", weight="bold")
    label(panel, end, data.edge_deg[-1], "smallest for\n1.5 kW", GREEN, va="center")
    panel.set_ylabel("advance angle (el. deg)")
    panel.set_ylim(0.0, 94.0)
