"""The paper's drive beside conventional ones over speed (section Optimal Efficiency Control, on its ref. 7)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_lab.paper.drives import (
    FASTEST_RPM,
    HIGHEST_PUBLISHED_RPM,
    ComparedDrive,
    at_rated_power,
    compared_drives,
    constant_power_range,
    reference_drive,
)
from drivegate_reports.page.style import BLUE, GREEN, GREY, ORANGE, VERMILION, label, new_grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SPEEDS_RPM: Final = tuple(float(speed) for speed in range(550, 3001, 50))
"""Speeds of the figure."""
_LOOKS: Final = ((BLUE, "-"), (VERMILION, "-"), (ORANGE, "--"), (GREEN, "-."))


@dataclass(frozen=True)
class DriveOverSpeed:
    """Rated power over speed at the angle of least Σ|i|, in the steady state; NaN where it is out of reach."""

    name: str
    """What the drive is called."""
    ripple_percent: NDArray[np.float64]
    """Torque ripple, peak to peak over mean (%), shape (n,)."""
    advance_deg: NDArray[np.float64]
    """The angle (electrical deg), shape (n,)."""
    current_sum_a: NDArray[np.float64]
    """Sum of current magnitudes (A), shape (n,)."""
    copper_loss_w: NDArray[np.float64]
    input_w: NDArray[np.float64]
    """Copper loss and net input power (W), shape (n,)."""
    from_rpm: float
    to_rpm: float
    """Range in which rated power is within reach (rpm)."""

    @property
    def range_words(self) -> str:
        """The range in words."""
        end = f"{self.to_rpm:.0f} rpm"
        return f"from {self.from_rpm:.0f} to {'at least ' if self.to_rpm >= FASTEST_RPM - 1.0 else ''}{end}"


@dataclass(frozen=True)
class ConventionalDrives:
    """The 5-phase drive and the stars over speed."""

    power_w: float
    """Rated power (W)."""
    speed_rpm: NDArray[np.float64]
    """Speeds (rpm), shape (n,)."""
    drives: tuple[DriveOverSpeed, ...]
    """The drives."""

    def ripple_at(self, speed_rpm: float) -> tuple[float, ...]:
        """Return the ripple of every drive at a speed (%)."""
        at = int(np.flatnonzero(self.speed_rpm == speed_rpm)[0])
        return tuple(float(drive.ripple_percent[at]) for drive in self.drives)


def _over_speed(drive: ComparedDrive) -> DriveOverSpeed:
    plant = drive.document.plant()
    found = [at_rated_power(plant, speed) for speed in SPEEDS_RPM]
    start, end = constant_power_range(drive.document)
    return DriveOverSpeed(
        drive.name,
        ripple_percent=np.array([one.ripple_percent for one in found]),
        advance_deg=np.array([one.advance_deg for one in found]),
        current_sum_a=np.array([one.point.current_sum for one in found]),
        copper_loss_w=np.array([one.point.copper_loss for one in found]),
        input_w=np.array([one.point.input_power for one in found]),
        from_rpm=start,
        to_rpm=end,
    )


@cache
def conventional_drives() -> ConventionalDrives:
    """Compute all drives over speed."""
    drives = tuple(_over_speed(drive) for drive in compared_drives())
    return ConventionalDrives(reference_drive().rating.rated_power_w, np.array(SPEEDS_RPM), drives)


TITLE = "Five phases against a conventional star (on section Optimal Efficiency Control)"


def alternative(data: ConventionalDrives) -> str:
    """Describe the figure in words, for who cannot see it."""
    ripple = "; ".join(
        f"{drive.name}: {value:.0f} %"
        for drive, value in zip(data.drives, data.ripple_at(HIGHEST_PUBLISHED_RPM), strict=True)
    )
    ranges = "; ".join(f"{drive.name}: {drive.range_words}" for drive in data.drives)
    return (
        "Torque ripple, angle, Σ|i|, copper loss and net input power over speed, and the range of constant power, of "
        f"four drives. Ripple at {HIGHEST_PUBLISHED_RPM:.0f} rpm: {ripple}. Range of {data.power_w / 1000.0:g} kW: "
        f"{ranges}."
    )


def caption(data: ConventionalDrives) -> str:
    """State what the figure shows."""
    ranges = "; ".join(f"{drive.range_words} ({drive.name})" for drive in data.drives)
    return (
        f"Steady states of {data.power_w / 1000.0:g} kW at the angle of least Σ|i|, with ideal current regulators and "
        "no core loss, of the paper's drive and of stars with the same iron and copper: the packaged drive "
        "`star-3-phase`, and two that differ from it in the EMF or in the windows. "
        f"{data.power_w / 1000.0:g} kW is within reach {ranges}; no further than {FASTEST_RPM:.0f} rpm was looked. At "
        "high speed the stars with windows of 120° take more current and more advance, with more ripple, and give out "
        "earlier; with windows of 150° a star takes no more current than five phases (finding F8). The axes of Σ|i| "
        "and of input power do not begin at zero."
    )


def draw(data: ConventionalDrives) -> Figure:
    """Draw the drives over speed, and the ranges of constant power."""
    figure = new_grid(5.2, 3, 2)
    panels = list(figure.axes)
    shown = (
        ("ripple_percent", "torque ripple (%)", True),
        ("advance_deg", "angle (el. deg)", True),
        ("current_sum_a", "Σ|i| (A)", False),
        ("copper_loss_w", "copper loss (W)", True),
        ("input_w", "net input power (W)", False),
    )
    for panel, (key, words, from_zero) in zip(panels, shown, strict=False):
        for drive, (colour, style) in zip(data.drives, _LOOKS, strict=True):
            panel.plot(data.speed_rpm, getattr(drive, key), color=colour, linestyle=style)
        panel.set_ylabel(words)
        if from_zero:
            panel.set_ylim(bottom=0.0)
        panel.set_xlim(SPEEDS_RPM[0], SPEEDS_RPM[-1])
        panel.axvline(HIGHEST_PUBLISHED_RPM, color=GREY, linewidth=0.8, linestyle=(0, (3, 3)))
    _draw_ranges(panels[-1], data)
    for panel in panels:
        panel.set_xlabel("speed (rpm)")
    return figure


def _draw_ranges(panel: Axes, data: ConventionalDrives) -> None:
    """Draw the ranges, whose names have the colours of all panels."""
    for place, (drive, (colour, _)) in enumerate(zip(data.drives, _LOOKS, strict=True)):
        height = -float(place)
        panel.plot([drive.from_rpm, drive.to_rpm], [height, height], color=colour, linewidth=3.0)
        label(panel, drive.from_rpm, height + 0.2, drive.name, colour, va="bottom")
    panel.set_ylim(-len(data.drives) + 0.6, 0.9)
    panel.set_yticks([])
    panel.set_xlim(0.0, 1.04 * FASTEST_RPM)
    panel.set_ylabel(f"range of {data.power_w / 1000.0:g} kW (lines)")
