"""Torque ripple of a star over inductance and EMF width at three times base speed (paper, on its ref. 7)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_lab.paper.drives import (
    HIGHEST_PUBLISHED_RPM,
    WIDE_DEG,
    power_torque,
    reference_drive,
    ripple_percent,
    star,
)
from drivegate_models.steady.oracle import feasible_edge, point_at_torque
from drivegate_models.units import RADIANS_PER_RPM
from drivegate_reports.page.style import GREY, VERMILION, label, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PUBLISHED_PERCENT: Final = (125.0, 144.0)
"""Ripple of the two drives of the cited work (%)."""
SHARES: Final = tuple(0.1 + 0.05 * step for step in range(23))
"""Inductances, as shares of the packaged star's (1)."""
FLATS_DEG: Final = tuple(60.0 + 5.0 * step for step in range(24))
"""Flat widths of the EMF (electrical deg)."""
FURTHER_DEG: Final = 15.0
"""How far above the smallest angle the second map lies (electrical deg)."""
_LEVELS: Final = (0.0, 25.0, 50.0, 75.0, 100.0, *PUBLISHED_PERCENT, 400.0)
_SHADES: Final = ("#F4F6F8", "#E1E8EE", "#C9D6E0", "#ADC1CF", "#8DA8BA", "#E69F00", "#5F7F95")


@dataclass(frozen=True)
class StarRipple:
    """Rated power of stars at one choice of the angle; NaN where it is out of reach."""

    further_deg: float
    """How far the angle lies above the smallest that gives rated power (electrical deg)."""
    ripple_percent: NDArray[np.float64]
    """Torque ripple, peak to peak over mean (%), shape (flats, inductances)."""
    lowest_nm: NDArray[np.float64]
    """Least torque (N·m), shape (flats, inductances)."""

    @property
    def as_published(self) -> NDArray[np.bool_]:
        """Where the ripple is that of the cited work, shape (flats, inductances)."""
        low, high = PUBLISHED_PERCENT
        return (self.ripple_percent >= low) & (self.ripple_percent <= high)

    @property
    def changes_sign(self) -> NDArray[np.bool_]:
        """Where the torque changes its sign, shape (flats, inductances)."""
        return self.lowest_nm < 0.0


@dataclass(frozen=True)
class RippleMap:
    """Ripple of stars over inductance and EMF width."""

    speed_rpm: float
    power_w: float
    """Speed (rpm) and power (W)."""
    inductance_mh: NDArray[np.float64]
    """Phase inductances (mH), shape (inductances,)."""
    flat_deg: NDArray[np.float64]
    """Flat widths of the EMF (electrical deg), shape (flats,)."""
    own_mh: float
    own_flat_deg: float
    """Those of the packaged star."""
    edge_deg: NDArray[np.float64]
    """Smallest angle that gives the power (electrical deg), shape (flats, inductances)."""
    necessary: StarRipple
    further: StarRipple
    """At that angle, and further on."""

    def flats_where(self, holds: NDArray[np.bool_]) -> tuple[float, float]:
        """Return the least and the greatest EMF width at which something holds for some inductance; NaN for none."""
        widths = self.flat_deg[holds.any(axis=1)]
        return (float(widths[0]), float(widths[-1])) if widths.size else (math.nan, math.nan)


@cache
def ripple_map() -> RippleMap:
    """Compute both maps."""
    power, own = reference_drive().rating.rated_power_w, star()
    assert own.machine.emf_flat_deg is not None, "the packaged star has a trapezoidal EMF"
    speed, torque = HIGHEST_PUBLISHED_RPM * RADIANS_PER_RPM, power_torque(HIGHEST_PUBLISHED_RPM, power)
    edges = np.full((len(FLATS_DEG), len(SHARES)), math.nan)
    values = np.full((2, 2, *edges.shape), math.nan)
    for row, flat in enumerate(FLATS_DEG):
        plant = own.replaced(emf_flat_deg=flat).plant()
        for column, share in enumerate(SHARES):
            drive = plant._replace(inductance=share * plant.inductance)
            edge = feasible_edge(drive, speed, torque)
            edges[row, column] = math.degrees(edge)
            for which, further in enumerate((0.0, FURTHER_DEG)):
                advance = edge + math.radians(further)
                if not advance <= 0.5 * math.pi:
                    continue
                point = point_at_torque(drive, speed, advance, torque)
                if point.robust:
                    values[which, :, row, column] = ripple_percent(point), point.torque_lowest
    return RippleMap(
        HIGHEST_PUBLISHED_RPM,
        power,
        np.array(SHARES) * own.machine.inductance_h * 1000.0,
        np.array(FLATS_DEG),
        own.machine.inductance_h * 1000.0,
        own.machine.emf_flat_deg,
        edges,
        StarRipple(0.0, *values[0]),
        StarRipple(FURTHER_DEG, *values[1]),
    )


TITLE = "Where a conventional star has the ripple of the cited work (on section Optimal Efficiency Control)"


def widths_in_words(data: RippleMap, holds: NDArray[np.bool_]) -> str:
    """State at which EMF widths something holds for some inductance."""
    low, high = data.flats_where(holds)
    if math.isnan(low):
        return "nowhere"
    return (
        f"with an EMF flat over {low:.0f}° or more"
        if high == data.flat_deg[-1]
        else f"from {low:.0f} to {high:.0f}°"
    )


def alternative(data: RippleMap) -> str:
    """Describe the figure in words, for who cannot see it."""
    low, high = PUBLISHED_PERCENT
    told = [
        f"{where} {low:.0f} to {high:.0f} % lies {widths_in_words(data, one.as_published)}, and the torque changes its "
        f"sign {widths_in_words(data, one.changes_sign)}"
        for where, one in _places(data)
    ]
    return (
        "Two maps of torque ripple over inductance and flat width of the EMF, in steps of shade. "
        f"{'; '.join(told)}. From a flat width of 125° upward ripple grows with the width; from "
        f"{data.inductance_mh[~np.isfinite(data.edge_deg).any(axis=0)].min():.2f} mH on the power is out of reach."
    )


def _places(data: RippleMap) -> tuple[tuple[str, StarRipple], ...]:
    return (
        ("At the smallest angle that gives the power", data.necessary),
        (f"{data.further.further_deg:g}° further on", data.further),
    )


def caption(data: RippleMap) -> str:
    """State what the figure shows."""
    low, high = PUBLISHED_PERCENT
    return (
        f"The star of the same iron and copper with other inductances and EMF widths, at {data.power_w / 1000.0:g} kW "
        f"and {data.speed_rpm:.0f} rpm, with ideal current regulators; the dots are `star-3-phase` and the same with "
        f"an EMF flat over {WIDE_DEG:g}°. Orange: a ripple of {low:.0f} to {high:.0f} %, as of the drives of the cited "
        "work; above the red line the torque changes its sign; blank: out of reach, or beyond 90°. The cited work's "
        "statement is reproduced in kind. Its size depends on EMF width, inductance and angle, which the paper does "
        "not tell of those machines, and on saliency, which is not modelled here."
    )


def draw(data: RippleMap) -> Figure:
    """Draw both maps."""
    figure, panels = new_figure(4.6, 2)
    for panel, (where, one) in zip(panels, _places(data), strict=True):
        _draw_map(panel, data, one)
        panel.set_title(where)
        panel.set_xlabel("phase inductance (mH)")
        panel.set_ylabel("flat width (el. deg)")
    return figure


def _draw_map(panel: Axes, data: RippleMap, one: StarRipple) -> None:
    grid = (data.inductance_mh, data.flat_deg)
    panel.contourf(*grid, one.ripple_percent, levels=_LEVELS, colors=_SHADES)
    lines = panel.contour(*grid, one.ripple_percent, levels=_LEVELS[1:-1], colors="#FFFFFF", linewidths=0.7)
    # The orange band is explained in the caption; a number on it would lie on that of the line beside it.
    panel.clabel(lines, levels=_LEVELS[1:5], fmt="%.0f %%", fontsize=8.0, colors="#22262E")
    panel.contour(*grid, one.lowest_nm, levels=[0.0], colors=VERMILION, linewidths=1.8)
    panel.plot(
        [data.own_mh] * 2,
        [data.own_flat_deg, WIDE_DEG],
        color="black",
        marker="o",
        markersize=5,
        linestyle="",
    )
    label(panel, 1.02 * data.own_mh, data.own_flat_deg, "star-3-phase", GREY, va="center")
    panel.set_xlim(float(data.inductance_mh[0]), float(data.inductance_mh[-1]))
