"""The torque over one electrical period that a ripple check judged, next to how high its ripple may be."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.contracts.current.words import RunSignals
from drivegate_cases.drive.limits import limits_of
from drivegate_models.errors import InputError
from drivegate_models.steady.oracle import point_at_torque
from drivegate_models.steady.plant import AnyDrive
from drivegate_models.steady.steady_state import steady_state
from drivegate_models.steady.waveform import periodic_waveforms
from drivegate_models.units import RADIANS_PER_RPM
from drivegate_reports.page.style import BLUE, DASHED, GREEN, VERMILION, label_ends, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_OF_STEADY_STATES: Final = ("RIP-1", "RIP-2")
_SHORT: Final = 0.999
TITLE: Final = "Torque over one electrical period"
_PERIOD_DEG: Final = 360.0


@dataclass(frozen=True)
class TorqueCycle:
    """Torque over one electrical cycle in the steady state with ideal current regulators."""

    angle_deg: NDArray[np.float64]
    """Electrical angle since the opening of the first phase's window (deg), shape (n,)."""
    torque_nm: NDArray[np.float64]
    """Electromagnetic torque (N·m), shape (n,)."""
    mean_nm: float
    lowest_nm: float
    highest_nm: float
    """Mean and exact extremes (N·m)."""
    speed_rpm: float
    advance_deg: float
    current_reference_a: float
    certified: bool
    """Whether the state repeats after the one cycle."""

    @property
    def ripple_percent(self) -> float:
        return 100.0 * (self.highest_nm - self.lowest_nm) / self.mean_nm

    @property
    def one_sided_ripple_percent(self) -> float:
        """Greatest deviation from the mean, over the mean (%)."""
        deviation = max(self.highest_nm - self.mean_nm, self.mean_nm - self.lowest_nm)
        return 100.0 * deviation / self.mean_nm


@dataclass(frozen=True)
class Ripple:
    """Torque over one electrical period at the operating point that a check judged."""

    cycle: TorqueCycle
    """The torque in the steady state at the angle and the mean torque of the judged stretch."""
    limit: float
    """Largest peak-to-peak ripple over the mean (1)."""
    demanded_nm: float
    """Mean torque of the judged stretch (N·m)."""

    @property
    def is_short(self) -> bool:
        """Whether the torque is out of reach, so that the cycle is that at the current limit."""
        return self.cycle.mean_nm < _SHORT * self.demanded_nm


def ripple_of(check: str, signals: RunSignals) -> Ripple | None:
    """Compute the torque at the judged operating point; None for other checks, and where there was no torque."""
    if check not in _OF_STEADY_STATES or not signals.judged.any():
        return None
    speed, angle, torque = (
        float(np.mean(values[signals.judged]))
        for values in (signals.speed_reference_rpm, signals.advance_deg, signals.torque_nm)
    )
    if speed <= 0.0 or torque <= 0.0:
        return None
    ideal = signals.scenario.drive.plant(signals.scenario.scales)._replace(hysteresis_band=0.0)
    try:
        cycle = cycle_at(ideal, speed, min(max(angle, 0.0), 90.0), torque)
    except InputError:
        return None
    limit = limits_of(signals.scenario.drive).ripple
    return Ripple(cycle, limit, torque) if cycle.mean_nm > 0.0 and np.isfinite(limit) else None


def alternative(ripple: Ripple) -> str:
    low, high = _extremes(ripple)
    return (
        f"The torque goes from {low:.2f} to {high:.2f} N·m around its mean of {ripple.cycle.mean_nm:.2f} N·m, a ripple "
        f"of {_percent(ripple):.1f} % peak to peak; the band allows {100.0 * ripple.limit:.0f} %."
    )


def caption(ripple: Ripple) -> str:
    cycle = ripple.cycle
    words = (
        f"Steady state at {cycle.speed_rpm:.0f} rpm, {cycle.advance_deg:.1f}° and {cycle.current_reference_a:.2f} A "
        f"with ideal current regulators: {_percent(ripple):.1f} % peak to peak over the mean. Shaded: the mean ± half "
        f"of the limit, {100.0 * ripple.limit:.0f} % peak to peak."
    )
    if ripple.is_short:
        words += (
            f" The {ripple.demanded_nm:.2f} N·m of the run are out of reach at that speed and angle; this is what "
            "the current limit gives."
        )
    return words


def draw(ripple: Ripple) -> Figure:
    figure, (panel,) = new_figure(2.0, 1, fitted=False)
    cycle = ripple.cycle
    half = 0.5 * ripple.limit * cycle.mean_nm
    border = cycle.mean_nm - half, cycle.mean_nm + half
    low, high = _extremes(ripple)
    panel.fill_between([0.0, _PERIOD_DEG], *border, color=GREEN, alpha=0.14, linewidth=0)
    panel.plot([0.0, _PERIOD_DEG], [cycle.mean_nm] * 2, color=GREEN, linewidth=1.2, linestyle=DASHED)
    panel.plot(cycle.angle_deg, cycle.torque_nm, color=BLUE, linewidth=1.4)
    least, greatest = min(low, border[0]), max(high, border[1])
    padding = 0.08 * (greatest - least)
    panel.set_xlim(0.0, 1.2 * _PERIOD_DEG)
    panel.set_ylim(least - padding, greatest + padding)
    panel.set_xticks(np.arange(0.0, _PERIOD_DEG + 1.0, 72.0))
    outside = VERMILION if _percent(ripple) > 100.0 * ripple.limit else BLUE
    label_ends(
        panel,
        1.012 * _PERIOD_DEG,
        (f"max {high:.2f}", high, outside),
        (f"mean {cycle.mean_nm:.2f}", cycle.mean_nm, GREEN),
        (f"min {low:.2f}", low, outside),
    )
    panel.set_xlabel("electrical angle since the first phase's window opened (el. deg)")
    panel.set_ylabel("torque (N·m)")
    return figure


def _extremes(ripple: Ripple) -> tuple[float, float]:
    """Return the least and the greatest torque that are drawn (N·m)."""
    return float(ripple.cycle.torque_nm.min()), float(ripple.cycle.torque_nm.max())


def _percent(ripple: Ripple) -> float:
    low, high = _extremes(ripple)
    return 100.0 * (high - low) / ripple.cycle.mean_nm


def cycle_at(drive: AnyDrive, speed_rpm: float, advance_deg: float, torque_nm: float) -> TorqueCycle:
    """Compute the torque at an operating point; at the current limit where the mean torque is out of reach."""
    speed = speed_rpm * RADIANS_PER_RPM
    advance = math.radians(advance_deg)
    found = point_at_torque(drive, speed, advance, torque_nm)
    reference = found.reference if found.static else drive.current_limit
    waves = periodic_waveforms(drive, speed, reference, advance)
    state = found if found.static else steady_state(drive, speed, reference, advance)
    return TorqueCycle(
        angle_deg=np.degrees(waves.angles),
        torque_nm=waves.torque,
        mean_nm=state.torque,
        lowest_nm=state.torque_lowest,
        highest_nm=state.torque_highest,
        speed_rpm=speed_rpm,
        advance_deg=advance_deg,
        current_reference_a=reference,
        certified=waves.certified,
    )
