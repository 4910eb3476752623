"""The drives of the paper's introduction side by side over speed: five phases, a star, and PM AC."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_lab.paper.drives import FASTEST_RPM, HIGHEST_PUBLISHED_RPM, reference_drive
from drivegate_lab.paper.kinds_of_drives import (
    KindOfDrive,
    common_power_w,
    in_words,
    kinds_of_drives,
    range_in_words,
)
from drivegate_reports.page.style import BLUE, GREEN, ORANGE, PURPLE, VERMILION, label, new_grid

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SPEEDS_RPM: Final = tuple(float(speed) for speed in range(550, 3001, 50))
"""Speeds of the figure."""
_LOOKS: Final = ((BLUE, "-"), (VERMILION, "-"), (GREEN, "-"), (PURPLE, "--"), (ORANGE, "-."))


@dataclass(frozen=True)
class KindOverSpeed:
    """One drive at the common power over speed; NaN where that is out of reach."""

    drive: KindOfDrive
    """The drive."""
    ripple_percent: NDArray[np.float64]
    """Torque ripple, peak to peak over mean (%), shape (n,)."""
    current_sum_a: NDArray[np.float64]
    current_sum_pu: NDArray[np.float64]
    """Sum of current magnitudes (A), and over that of all phases at the current limit (1), shape (n,)."""
    copper_loss_w: NDArray[np.float64]
    input_w: NDArray[np.float64]
    """Copper loss and net input power (W), shape (n,)."""


@dataclass(frozen=True)
class KindsOverSpeed:
    """The drives over speed."""

    power_w: float
    rated_power_w: float
    """Power at which they are compared, and rated power of the paper's drive (W)."""
    speed_rpm: NDArray[np.float64]
    """Speeds (rpm), shape (n,)."""
    kinds: tuple[KindOverSpeed, ...]
    """The drives."""


def _over_speed(drive: KindOfDrive, power_w: float) -> KindOverSpeed:
    points = [drive.at(speed, power_w) for speed in SPEEDS_RPM]
    sums = np.array([point.current_sum_a for point in points])
    return KindOverSpeed(
        drive,
        ripple_percent=np.array([point.ripple_percent for point in points]),
        current_sum_a=sums,
        current_sum_pu=sums / drive.current_sum_base_a,
        copper_loss_w=np.array([point.copper_loss_w for point in points]),
        input_w=np.array([point.input_w for point in points]),
    )


@cache
def kinds_over_speed() -> KindsOverSpeed:
    """Compute all drives over speed."""
    power = common_power_w()
    kinds = tuple(_over_speed(drive, power) for drive in kinds_of_drives())
    return KindsOverSpeed(power, reference_drive().rating.rated_power_w, np.array(SPEEDS_RPM), kinds)


TITLE = "Five phases, a star and PM AC at the same power (on section Introduction)"


def alternative(data: KindsOverSpeed) -> str:
    """Describe the figure in words, for who cannot see it."""
    told = "; ".join(
        f"{kind.drive.name}: {in_words(kind.drive, HIGHEST_PUBLISHED_RPM, data.power_w)}"
        for kind in data.kinds
    )
    return (
        "Torque ripple, Σ|i| in amperes and per unit, copper loss and net input power over speed, and the ranges of "
        f"two powers, of five drives. {data.power_w:g} W at {HIGHEST_PUBLISHED_RPM:.0f} rpm: {told}."
    )


def caption(data: KindsOverSpeed) -> str:
    """State what the figure shows."""
    ranges = "; ".join(
        f"{range_in_words(kind.drive, data.rated_power_w)} ({kind.drive.name})" for kind in data.kinds
    )
    return (
        f"{data.power_w:g} W at the shaft, at the best that each drive can do, since no one controller runs on all of "
        "them: the 5-phase drive and the star at the angle of least Σ|i| with ideal current regulators, the PM AC "
        "drives at the least current that gives the torque within the voltage of undistorted modulation; all without "
        "core loss and without a ripple of switching, on the same 96 V. `pm-ac-surface` is three of the five phases, "
        "with three fifths of the copper and a sine as high as the paper's trapezoid for its EMF; beside it are two "
        "machines with all of the copper in three phases, as the star has it: one with that sine, and one with the "
        "trapezoid's fundamental, which is higher. Per unit is the current limit of all phases. "
        f"{data.rated_power_w / 1000.0:g} kW, rated power of the paper's drive (thick lines): {ranges} (finding F9). "
        "The axes of Σ|i| and of input power do not begin at zero."
    )


def draw(data: KindsOverSpeed) -> Figure:
    """Draw the drives over speed, and the ranges of both powers."""
    figure = new_grid(5.2, 3, 2)
    panels = list(figure.axes)
    shown = (
        ("ripple_percent", "torque ripple (%)", True),
        ("copper_loss_w", "copper loss (W)", True),
        ("current_sum_a", "Σ|i| (A)", False),
        ("current_sum_pu", "Σ|i| (pu)", False),
        ("input_w", "net input power (W)", False),
    )
    for panel, (key, words, from_zero) in zip(panels, shown, strict=False):
        for kind, (colour, style) in zip(data.kinds, _LOOKS, strict=True):
            panel.plot(data.speed_rpm, getattr(kind, key), color=colour, linestyle=style)
        panel.set_ylabel(words)
        if from_zero:
            panel.set_ylim(bottom=-1.0)
        panel.set_xlim(SPEEDS_RPM[0], SPEEDS_RPM[-1])
    _draw_ranges(panels[-1], data)
    for panel in panels:
        panel.set_xlabel("speed (rpm)")
    return figure


def _draw_ranges(panel: Axes, data: KindsOverSpeed) -> None:
    """Draw the ranges, thick those of rated power; their names have the colours of all panels."""
    for place, (kind, (colour, _)) in enumerate(zip(data.kinds, _LOOKS, strict=True)):
        height = -float(place)
        for power, width in ((data.power_w, 1.2), (data.rated_power_w, 4.0)):
            found = kind.drive.power_range(power)
            if found is not None:
                panel.plot(found, [height, height], color=colour, linewidth=width, solid_capstyle="butt")
        label(panel, 300.0, height + 0.2, kind.drive.name, colour, va="bottom")
    panel.set_ylim(-len(data.kinds) + 0.6, 0.9)
    panel.set_yticks([])
    panel.set_xlim(0.0, 1.04 * FASTEST_RPM)
    panel.set_ylabel("ranges of both (lines)")
