"""Voltage, both EMFs and current of one phase over a cycle at constant power (paper, Fig. 1)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drivegate_cases.scenario.operating_point import load_operating_point
from drivegate_lab.paper.drives import ideal_drive
from drivegate_models.steady.oracle import point_at_torque
from drivegate_models.steady.waveform import periodic_waveforms
from drivegate_models.units import RADIANS_PER_RPM
from drivegate_reports.page.style import BLUE, GREEN, GREY, VERMILION, label, new_figure, signed

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

POINT = "fig10-currents-1500"


@dataclass(frozen=True)
class CycleWaveforms:
    """One phase over one electrical cycle in the steady state with an ideal current regulator."""

    speed_rpm: float
    torque_nm: float
    advance_deg: float
    window_deg: float
    """The operating point and the width of the conduction window."""
    angle_deg: NDArray[np.float64]
    """Electrical angle since the opening of the phase's positive window (deg), shape (n,)."""
    voltage_v: NDArray[np.float64]
    emf_v: NDArray[np.float64]
    transformer_emf_v: NDArray[np.float64]
    """Terminal voltage v, rotational EMF e, and L di/dt (V), shape (n,)."""
    current_a: NDArray[np.float64]
    """Phase current (A), shape (n,)."""
    meeting_deg: float
    """Angle at which the rotational EMF outgrows the half-supply: point 2 of Fig. 1 (deg)."""

    @property
    def opposing_v(self) -> float:
        """Mean L di/dt from point 2 to the end of the window, negative where it opposes the rotational EMF (V)."""
        inside = (self.angle_deg > self.meeting_deg) & (self.angle_deg < self.window_deg)
        return float(np.mean(self.transformer_emf_v[inside]))

    @property
    def rise_a(self) -> float:
        """Change of the current from point 1, the opening of the window, to point 2 (A)."""
        return self._current(self.meeting_deg) - self._current(0.0)

    @property
    def fall_a(self) -> float:
        """Change of the current from point 2 to point 3, the end of the window (A)."""
        return self._current(self.window_deg) - self._current(self.meeting_deg)

    def _current(self, angle_deg: float) -> float:
        return float(np.interp(angle_deg, self.angle_deg, self.current_a))


@cache
def cycle_waveforms() -> CycleWaveforms:
    """Compute the waveforms at the point of Fig. 10, since Fig. 1 names none."""
    point = load_operating_point(POINT)
    drive = ideal_drive()
    speed = point.speed_rpm * RADIANS_PER_RPM
    advance = math.radians(point.advance_deg)
    found = point_at_torque(drive, speed, advance, point.torque_nm)
    waves = periodic_waveforms(drive, speed, found.reference, advance)
    angle = np.degrees(waves.angles)
    emf = drive.emf_constant * speed * waves.shapes[0]
    current = waves.currents[0]
    window = math.degrees(drive.window)
    ahead = np.flatnonzero((emf > drive.half_supply_voltage) & (angle < window))
    return CycleWaveforms(
        speed_rpm=point.speed_rpm,
        torque_nm=point.torque_nm,
        advance_deg=point.advance_deg,
        window_deg=window,
        angle_deg=angle,
        voltage_v=waves.voltages[0],
        emf_v=emf,
        transformer_emf_v=waves.voltages[0] - drive.resistance * current - emf,
        current_a=current,
        meeting_deg=float(angle[ahead[0]]) if ahead.size else math.nan,
    )


TITLE = "One phase over a cycle at constant power (Fig. 1)"


def alternative(data: CycleWaveforms) -> str:
    """Describe the figure in words, for who cannot see it."""
    return (
        f"Upper panel: the terminal voltage is a square of 48 V; the rotational EMF is a trapezoid of "
        f"{data.emf_v.max():.1f} V that outgrows it {data.meeting_deg:.0f}° after the window opens. From there the "
        f"transformer EMF is {signed(data.opposing_v, 1)} V. Lower panel: the current rises by {data.rise_a:.1f} A up "
        f"to that point and falls by {-data.fall_a:.1f} A until the window closes."
    )


def caption(data: CycleWaveforms) -> str:
    """State what the figure shows."""
    return (
        f"Steady state at {data.speed_rpm:.0f} rpm, {data.torque_nm:g} N·m and {data.advance_deg:g}° with an ideal "
        f"regulator. From 1 to 2 the supply exceeds the rotational EMF and the current rises, up to the reference of "
        f"{data.current_a.max():.1f} A, which the regulator holds. From 2 to 3 the EMF exceeds the supply, the "
        f"current falls, and the transformer EMF, {signed(data.opposing_v, 1)} V in the mean, opposes the rotational "
        "one. Fig. 1 names no operating point; this is that of Fig. 10."
    )


def draw(data: CycleWaveforms) -> Figure:
    """Draw the voltages over the current."""
    figure, panels = new_figure(5.6, 2, (1.5, 1.0))
    _draw_voltages(panels[0], data)
    _draw_current(panels[1], data)
    for panel in panels:
        for number, angle in enumerate((0.0, data.meeting_deg, data.window_deg), start=1):
            panel.axvline(angle, color=GREY, linewidth=0.8, linestyle=(0, (3, 3)))
            panel.annotate(
                str(number), (angle, 1.0), xycoords=("data", "axes fraction"), ha="center", va="bottom"
            )
        panel.set_xlim(-6.0, 366.0)
        panel.set_xticks(np.arange(0.0, 361.0, 36.0))
        panel.set_xlabel("electrical angle since the window opened (el. deg)")
    return figure


def _draw_voltages(panel: Axes, data: CycleWaveforms) -> None:
    panel.plot(data.angle_deg, data.transformer_emf_v, color=GREEN, linewidth=1.2)
    panel.plot(data.angle_deg, data.voltage_v, color=BLUE)
    panel.plot(data.angle_deg, data.emf_v, color=VERMILION)
    label(panel, 24.0, 82.0, "L di/dt: transformer EMF", GREEN, weight="bold")
    label(panel, 222.0, 62.0, "v: terminal voltage", BLUE, weight="bold")
    label(panel, 318.0, 30.0, "e: rotational\nEMF", VERMILION, weight="bold", ha="right", va="center")
    panel.set_ylabel("voltage (V)")


def _draw_current(panel: Axes, data: CycleWaveforms) -> None:
    panel.plot(data.angle_deg, data.current_a, color=BLUE)
    panel.axhline(0.0, color=GREY, linewidth=0.8)
    label(panel, 100.0, 5.0, "i: phase current", BLUE, weight="bold", ha="center")
    panel.set_ylabel("phase current (A)")
