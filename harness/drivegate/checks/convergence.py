"""Checks of the search: that it converges, where to, and that constant power is held."""

from __future__ import annotations

import math

from drivegate.check import Check
from drivegate.margin import Margin
from drivegate.run_record import RunRecord, Window, rated_torque
from drivegate.scenario_run import RADIANS_PER_RPM
from drivegate_cases.load import ConstantPowerLoad
from drivegate_models import observation
from drivegate_models.oracle import least_current_sum

SPEED_TOLERANCE = 5.0 * RADIANS_PER_RPM
"""k1 (rad/s)."""
POWER_TOLERANCE = 0.005
"""k2, as a share of the current sum (1)."""
ANGLE_TOLERANCE = math.radians(1.0)
"""Greatest movement of the advance angle of a search that has converged (rad)."""
OPTIMUM_TOLERANCE = 0.02
"""Greatest excess of the current sum over the least one (1)."""
REQUIRED_SHARE = 0.5
"""Share of the rated power's torque from which the optimum is required (1)."""
HIGHEST_REQUIRED_SPEED = 1500.0 * RADIANS_PER_RPM
"""Speed up to which constant power is required, three times base speed (rad/s)."""


def _speed_margin(window: Window) -> float:
    return 1.0 - float(window.values[observation.WINDOW_SPEED_ERROR]) / SPEED_TOLERANCE


def _window_margin(window: Window) -> tuple[float, str]:
    """Return the least of a window's three margins, and what it was measured on."""
    values = window.values
    mean = float(values[observation.WINDOW_CURRENT_SUM])
    spread = float(values[observation.WINDOW_MEAN_HIGHEST] - values[observation.WINDOW_MEAN_LOWEST])
    moved = float(values[observation.WINDOW_ANGLE_HIGHEST] - values[observation.WINDOW_ANGLE_LOWEST])
    share = spread / mean if mean > 0.0 else 0.0
    error = float(values[observation.WINDOW_SPEED_ERROR])
    return min(
        (1.0 - error / SPEED_TOLERANCE, f"speed error {error / RADIANS_PER_RPM:.4g} rpm"),
        (1.0 - share / POWER_TOLERANCE, f"Σ|i| varies by {100.0 * share:.3g} %"),
        (1.0 - moved / ANGLE_TOLERANCE, f"angle moves by {math.degrees(moved):.3g}°"),
    )


def _at(window: Window) -> str:
    torque = float(window.values[observation.WINDOW_TORQUE])
    return f" at {window.dwell.speed_rpm:.4g} rpm, {torque:.3g} N·m"


def converges(record: RunRecord) -> Margin | None:
    """Judge whether the search has converged in every window (paper, Fig. 4).

    Parameters
    ----------
    record : RunRecord
        The run.

    Returns
    -------
    Margin or None
        The worst of speed error over k1, spread of the 100 ms means of the current sum over k2, and movement
        of the angle over 1°; None where no reference is steady for long enough.
    """
    margins = [
        (*_window_margin(window), window)
        for window in record.windows()
        if window.dwell.speed_rpm > record.scenario.motor.base_speed_rpm
    ]
    if not margins:
        return None
    value, measured, window = min(margins, key=lambda margin: margin[0])
    return Margin("CNV-1", value, measured + _at(window))


def reaches_optimum(record: RunRecord) -> Margin | None:
    """Judge the current sum of every converged window against the least one of the same plant (Figs. 5, 7).

    Parameters
    ----------
    record : RunRecord
        The run.

    Returns
    -------
    Margin or None
        Of the worst window; None where nothing is loaded and steady above base speed.
    """
    margins = []
    for window in record.windows():
        torque = float(window.values[observation.WINDOW_TORQUE])
        if window.dwell.load_factor == 0.0 or window.dwell.speed_rpm <= record.scenario.motor.base_speed_rpm:
            continue
        share = torque / rated_torque(record.scenario, window.speed)
        mean = float(window.values[observation.WINDOW_CURRENT_SUM])
        least = least_current_sum(record.drive, window.speed, torque, window.dwell.supply_v)
        if not math.isfinite(least.current_sum):
            margins.append((-1.0, f"Σ|i| {mean:.4g} A where no angle is feasible{_at(window)}", share))
            continue
        excess = mean / least.current_sum - 1.0
        measured = (
            f"Σ|i| {mean:.4g} A, {100.0 * excess:+.2f} % of the least {least.current_sum:.4g} A{_at(window)}"
        )
        margins.append((1.0 - excess / OPTIMUM_TOLERANCE, measured, share))
    if not margins:
        return None
    value, measured, share = min(margins)
    return Margin("CNV-2", value, measured, advisory=share < REQUIRED_SHARE * (1.0 - 1e-3))


def holds_constant_power(record: RunRecord) -> Margin | None:
    """Judge whether rated power is held within k1 (paper, "Constant Power Operation", Fig. 3).

    Parameters
    ----------
    record : RunRecord
        The run.

    Returns
    -------
    Margin or None
        Speed error over k1 in the worst window; None where no window asks for rated power at 550 to 1500 rpm.
    """
    load = record.scenario.load
    if not isinstance(load, ConstantPowerLoad) or load.power_w < record.scenario.motor.rated_power_w:
        return None
    windows = [
        window
        for window in record.windows()
        if window.dwell.load_factor == 1.0 and window.speed <= HIGHEST_REQUIRED_SPEED * (1.0 + 1e-9)
    ]
    if not windows:
        return None
    worst = min(windows, key=_speed_margin)
    error = float(worst.values[observation.WINDOW_SPEED_ERROR]) / RADIANS_PER_RPM
    return Margin("CPW-1", _speed_margin(worst), f"speed error {error:.4g} rpm{_at(worst)}")


CNV_1 = Check(
    "CNV-1",
    "Within 6 s of a steady reference the search has converged: from then on the true speed error stays within "
    "k1, the 100 ms means of Σ|i| within k2, and the advance angle within 1°.",
    "P6",
    "candidate",
    "required",
    "k1 = 5 rpm, k2 = 0.5 % of Σ|i|, 1°",
    "every steady stretch of 9 s or more above base speed",
    converges,
)
CNV_2 = Check(
    "CNV-2",
    "The search converges to the optimum: Σ|i| lies within 2 % of the least that any angle gives at that speed "
    "and mean torque; required from half the torque of rated power upward, advisory below.",
    "P6, P11, P12",
    "candidate",
    "required",
    "2 % above the least Σ|i|",
    "every loaded steady stretch above base speed",
    reaches_optimum,
)
CPW_1 = Check(
    "CPW-1",
    "Constant power: 1.5 kW is held within k1 at every speed from 550 to 1500 rpm.",
    "P5, P10",
    "candidate",
    "required",
    "k1 = 5 rpm",
    "runs under a constant power load of 1.5 kW",
    holds_constant_power,
)
