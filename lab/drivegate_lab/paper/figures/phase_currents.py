"""Phase currents at the published operating points (paper, Figs. 9 and 10)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drivegate_cases.scenario.operating_point import load_operating_point
from drivegate_lab.paper.drives import banded_drive
from drivegate_models.steady.oracle import point_at_torque
from drivegate_models.steady.waveform import periodic_waveforms
from drivegate_models.units import RADIANS_PER_RPM
from drivegate_reports.page.style import BLUE, GREY, VERMILION, label, new_figure, signed

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

POINTS = ("fig9-currents-1200", "fig10-currents-1500")
_SLOPE_FROM_DEG = 100.0
_SLOPE_TO_DEG = 140.0


@dataclass(frozen=True)
class PhaseCurrents:
    """Currents over one electrical cycle in the steady state, with the drive's current band."""

    name: str
    """The operating point."""
    speed_rpm: float
    torque_nm: float
    advance_deg: float
    current_reference_a: float
    """The operating point."""
    time_ms: NDArray[np.float64]
    """Time since the opening of the first phase's window (ms), shape (n,)."""
    current_a: NDArray[np.float64]
    """Phase currents (A), shape (m, n)."""
    slope_a_per_ms: float
    """Mean slope of the first phase's current from 100° to 140° of its window of 144° (A/ms)."""
    peak_emf_v: float
    """Peak back-EMF at this speed (V)."""
    certified: bool
    """Whether the state repeats after the one cycle."""


@cache
def phase_currents(name: str) -> PhaseCurrents:
    """Compute the currents at one published operating point."""
    point = load_operating_point(name)
    drive = banded_drive()
    speed = point.speed_rpm * RADIANS_PER_RPM
    advance = math.radians(point.advance_deg)
    found = point_at_torque(drive, speed, advance, point.torque_nm)
    # Of a mix of two references only one can be shown: the one that lasts longer.
    reference = found.reference_high if found.share > 0.5 else found.reference_low
    waves = periodic_waveforms(drive, speed, reference, advance)
    time_ms = waves.times * 1e3
    span = np.array([_SLOPE_FROM_DEG, _SLOPE_TO_DEG]) / 360.0 * waves.cycle * 1e3
    first, last = np.interp(span, time_ms, waves.currents[0])
    return PhaseCurrents(
        name=name,
        speed_rpm=point.speed_rpm,
        torque_nm=point.torque_nm,
        advance_deg=point.advance_deg,
        current_reference_a=reference,
        time_ms=time_ms,
        current_a=waves.currents,
        slope_a_per_ms=float((last - first) / (span[1] - span[0])),
        peak_emf_v=drive.emf_constant * speed,
        certified=waves.certified,
    )


TITLE = "Phase currents (Figs. 9 and 10)"


def alternative(figures: tuple[PhaseCurrents, ...]) -> str:
    """Describe the figure in words, for who cannot see it."""
    return " ".join(
        f"At {data.speed_rpm:.0f} rpm the current of each phase rises to {float(np.max(data.current_a)):.1f} A, "
        f"changes by {signed(data.slope_a_per_ms, 1)} A/ms before its window closes, and returns to zero before it "
        "reverses."
        for data in figures
    )


def caption(figures: tuple[PhaseCurrents, ...]) -> str:
    """State what the figure shows."""
    peaks = " and ".join(f"{data.peak_emf_v:.1f} V at {data.speed_rpm:.0f} rpm" for data in figures)
    return (
        "One electrical cycle of the steady state at the published operating points, with the hysteresis band, in "
        f"the published divisions of 10 A and 0.5 ms. Phase 1 is in front. The peak EMF is {peaks}; the half-supply "
        "is 48 V. Only where the EMF is higher than the supply does the current fall before its window closes."
    )


def draw(figures: tuple[PhaseCurrents, ...]) -> Figure:
    """Draw the currents of each point, the first phase's in front."""
    figure, panels = new_figure(2.9 * len(figures), len(figures))
    longest = max(float(data.time_ms[-1]) for data in figures)
    for panel, data in zip(panels, figures, strict=True):
        _draw_point(panel, data)
        panel.set_xlim(0.0, longest)
    return figure


def _draw_point(panel: Axes, data: PhaseCurrents) -> None:
    for current in data.current_a[1:]:
        panel.plot(data.time_ms, current, color=GREY, linewidth=0.8, alpha=0.7)
    panel.plot(data.time_ms, data.current_a[0], color=BLUE)
    end = data.time_ms[-1] * _SLOPE_TO_DEG / 360.0
    label(panel, 0.35 * end, 15.0, "phase 1", BLUE, weight="bold", ha="center")
    text = f"{signed(data.slope_a_per_ms, 1)} A/ms before the window closes"
    label(panel, 1.12 * end, 15.0, text, VERMILION)
    panel.set_title(f"{data.speed_rpm:.0f} rpm, {data.torque_nm:g} N·m, {data.advance_deg:.0f}°")
    panel.set_xlabel("time (ms)")
    panel.set_ylabel("phase current (A)")
    panel.set_yticks([-20.0, -10.0, 0.0, 10.0, 20.0])
    panel.set_ylim(-20.0, 20.0)
    panel.set_xticks(np.arange(0.0, data.time_ms[-1] + 0.01, 0.5))
