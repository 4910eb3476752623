"""Steady states and torque steps of a run with duty ratios, measured by the best that the drive could have done."""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil, isfinite, pi
from typing import Any, Final

from drivegate.checks.duty.current import losses
from drivegate.checks.duty.judged import plant_of
from drivegate.checks.duty.optimum import CURRENT, least_within, undistorted
from drivegate.checks.duty.steps import step_responses
from drivegate.drives.pm_ac_torque import torque_course
from drivegate.runs.duty.record import DutyRecord, DutyWindow
from drivegate_models.pm_ac.fundamental import SteadyState

Row = dict[str, Any]

_SIXTH: Final = pi / 3.0
_FEWEST_PERIODS: Final = 20
_MOST_PERIODS: Final = 200


def steady_points(record: DutyRecord) -> list[Row]:
    """Tell the steady states of a run whose reference is a torque."""
    return [_steady_point(record, window) for window in record.steady if window.torque_reference is not None]


def _steady_point(record: DutyRecord, window: DutyWindow) -> Row:
    wanted, limits = window.torque_reference or 0.0, record.limits
    own, cool = losses(record, window)
    least = least_within(plant_of(record), window.speed, window.link, own.torque, CURRENT)
    return {
        "speed_rpm": window.dwell.speed_rpm,
        "reference_nm": wanted,
        "torque_nm": window.torque,
        "held": abs(window.torque - wanted) <= limits.torque_error_nm,
        "direct_current_a": own.direct,
        "quadrature_current_a": own.quadrature,
        "current_above_least_percent": _above(own.current, least.current),
        "loss_w": own.loss,
        "least_loss_w": cool.loss if isfinite(cool.loss) else None,
        "loss_above_least_percent": _above(own.loss, cool.loss),
        "efficiency_percent": efficiency(own, window.speed),
        "voltage_percent": 100.0 * window.voltage / undistorted(window.link),
        "ripple_percent": 100.0 * _swing(record, window) / limits.rated_torque_nm,
    }


def efficiency(state: SteadyState, speed: float) -> float | None:
    """Give the mechanical power over that and the losses (%); None where no power is given to the shaft."""
    power = state.torque * speed
    return 100.0 * power / (power + state.loss) if power > 0.0 else None


def _above(own: float, least: float) -> float | None:
    return 100.0 * (own / least - 1.0) if isfinite(least) and least > 0.0 else None


def _swing(record: DutyRecord, window: DutyWindow) -> float:
    """Give the greatest less the least torque at any instant of a sixth of an electrical period (N·m)."""
    length = record.scenario.control_period_s
    turning = record.document.machine.pole_pairs * abs(window.speed)
    wanted = ceil(_SIXTH / (turning * length)) if turning > 0.0 else 0
    count = min(max(wanted, _FEWEST_PERIODS), _MOST_PERIODS)
    course = torque_course(record, round(window.end_s / length) - count, count)
    return float(course.greatest.max() - course.least.min())


def step_rows(record: DutyRecord) -> Iterator[Row]:
    """Tell the steps of the torque reference that the voltage leaves room for."""
    for response in step_responses(record):
        step = response.step
        yield {
            "speed_rpm": step.speed_rpm,
            "before_nm": step.before,
            "after_nm": step.after,
            "overshoot_percent": 100.0 * response.overshoot,
            "rise_ms": 1e3 * response.rise_s if isfinite(response.rise_s) else None,
            "allowed_ms": 1e3 * response.allowed_s,
        }
