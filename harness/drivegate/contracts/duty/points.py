"""Steady states and torque steps of a run with duty ratios, measured by the best that the drive could have done."""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil, isfinite, pi
from typing import Any, Final

from drivegate.checks.means import exact_mean
from drivegate.contracts.duty.best_operation import efficiency
from drivegate.contracts.duty.checks.current import losses
from drivegate.contracts.duty.checks.judged import least_within, undistorted
from drivegate.contracts.duty.checks.steps import step_responses
from drivegate.contracts.duty.record import DutyRecord, DutyWindow
from drivegate.contracts.duty.torque import torque_course
from drivegate_cases.scenario.load import LockedLoad
from drivegate_models.units import RADIANS_PER_RPM

Row = dict[str, Any]

_SIXTH: Final = pi / 3.0
_FEWEST_PERIODS: Final = 20
_MOST_PERIODS: Final = 200


def steady_points(record: DutyRecord) -> list[Row]:
    """Return the steady states of a run whose reference is a torque, or a speed under a constant load."""
    return [_steady_point(record, window) for window in record.steady]


def _steady_point(record: DutyRecord, window: DutyWindow) -> Row:
    own, cool = losses(record, window)
    power = record.run.column("input_power")[record.periods(window.start_s, window.end_s)]
    least = least_within(record.plant, window.speed, window.link, own.torque, "current")
    return {
        "speed_rpm": window.dwell.speed_rpm,
        **_required(record, window),
        "torque_nm": window.torque,
        "direct_current_a": own.direct,
        "quadrature_current_a": own.quadrature,
        "current_above_least_percent": _above(own.current, least.current),
        "input_power_w": exact_mean(power),
        "loss_w": own.loss,
        "least_loss_w": cool.loss if isfinite(cool.loss) else None,
        "loss_above_least_percent": _above(own.loss, cool.loss),
        "efficiency_percent": efficiency(own, window.speed),
        "voltage_percent": 100.0 * window.voltage / undistorted(record.plant, window.link),
        "ripple_percent": 100.0 * _swing(record, window) / record.document.rating.rated_torque_nm,
    }


def _required(record: DutyRecord, window: DutyWindow) -> Row:
    """Return the torque that is asked for, of a speed reference the load's, and whether the reference is held."""
    limits, reference = record.limits, window.torque_reference
    if reference is not None:
        return {"reference_nm": reference, "held": abs(window.torque - reference) <= limits.torque_error_nm}
    load, speed = record.scenario.load, window.dwell.speed_rpm
    assert not isinstance(load, LockedLoad), "a speed reference is followed under a load"
    error = abs(window.speed / RADIANS_PER_RPM - speed)
    return {
        "reference_nm": load.torque_at(speed, window.dwell.load_factor),
        "held": error <= limits.speed_tolerance_rpm,
    }


def _above(own: float, least: float) -> float | None:
    return 100.0 * (own / least - 1.0) if isfinite(least) and least > 0.0 else None


def _swing(record: DutyRecord, window: DutyWindow) -> float:
    """Return the greatest less the least torque at any instant of a sixth of an electrical period (N·m)."""
    length = record.scenario.control_period_s
    turning = record.document.machine.pole_pairs * abs(window.speed)
    wanted = ceil(_SIXTH / (turning * length)) if turning > 0.0 else 0
    count = min(max(wanted, _FEWEST_PERIODS), _MOST_PERIODS)
    course = torque_course(record, round(window.end_s / length) - count, count)
    return float(course.greatest.max() - course.least.min())


def step_rows(record: DutyRecord) -> Iterator[Row]:
    """Return the steps of the torque reference that the voltage leaves room for."""
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
