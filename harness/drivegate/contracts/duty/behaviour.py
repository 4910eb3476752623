"""How a controller of duty ratios behaves in plain runs, in the numbers that a report shows of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import isfinite
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.checks.check import Record
from drivegate.contracts.duty.best_operation import efficiency
from drivegate.contracts.duty.checks.current import EFFICIENCY_POINTS, efficiency_windows, losses
from drivegate.contracts.duty.checks.judged import duty_record
from drivegate.contracts.duty.checks.steps import decisive_step
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.scenarios.fixed import efficiency_scenarios, range_scenario, release_scenario
from drivegate.contracts.duty.scenarios.unsensed import unfair_without_sensor
from drivegate.contracts.duty.torque import amplitudes, torque_course
from drivegate_cases.documents.wording import significant
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.units import RADIANS_PER_RPM

Run = Callable[[Scenario], Record]
"""Runs the candidate through a scenario."""

MOST_POINTS: Final = 300
"""Most points of a curve."""
_BEFORE: Final = 10
_LEAST_SHOWN: Final = 60
_MOST_SHOWN: Final = 200
_MOST_TURNS: Final = 4
_FOLLOWED_PERIODS: Final = 400
_MOST_PERIODS: Final = 1500
_HIGHEST_CARRIERS: Final = 2.25
_DIGITS: Final = 5
_AMPLITUDE_PLACES: Final = 4


def behaviour(run: Run, drive: PmAcDocument, step: Scenario | None) -> dict[str, Any]:
    """Run a candidate through plain scenarios, and the one that shows its steps; give what a report shows of it."""
    fair = [scenario for scenario in efficiency_scenarios(drive) if unfair_without_sensor(scenario) is None]
    records = [duty_record(run(scenario)) for scenario in fair]
    return {
        "step": None if step is None else _step(duty_record(run(step))),
        "range": _path(duty_record(run(range_scenario(drive)))),
        "release": _path(duty_record(run(release_scenario(drive)))) if drive.weakens else None,
        "points": [point for record in records for point in _points(record)],
        "torque": _torque(records[-1]),
    }


def _step(record: DutyRecord) -> dict[str, Any] | None:
    response = decisive_step(record)
    if response is None:
        return None
    step, period = response.step, record.scenario.control_period_s
    shown = min(max(round(3.0 * response.allowed_s / period), _LEAST_SHOWN), _MOST_SHOWN)
    begin = step.rows.start
    rows = slice(max(begin - _BEFORE, 0), min(begin + shown, step.rows.stop))
    time = (np.arange(rows.start, rows.stop) - begin + 1) * period
    return {
        "speed_rpm": step.speed_rpm,
        "before_nm": step.before,
        "after_nm": step.after,
        "overshoot_percent": _rounded(100.0 * response.overshoot),
        "rise_ms": _rounded(1e3 * response.reached_s),
        "reached_percent": _rounded(100.0 * response.reached),
        "allowed_ms": _rounded(1e3 * response.allowed_s),
        "overshoot_limit_percent": _rounded(100.0 * response.allowed_overshoot),
        "time_ms": _listed(1e3 * time),
        "torque_nm": _listed(record.run.column("torque")[rows]),
        "direct_current_a": _listed(record.run.column("direct")[rows]),
        "quadrature_current_a": _listed(record.run.column("quadrature")[rows]),
    }


def _path(record: DutyRecord) -> dict[str, Any]:
    """Return the currents of the rotor frame through a run: densest where they move fastest."""
    direct, quadrature = (record.run.column(name) for name in ("direct", "quadrature"))
    steps = np.diff(direct, prepend=direct[0]), np.diff(quadrature, prepend=quadrature[0])
    # Roots and products are rounded alike everywhere, as hypot is not.
    way = np.cumsum(np.sqrt(steps[0] * steps[0] + steps[1] * steps[1]))
    places = np.searchsorted(way, np.linspace(0.0, way[-1], MOST_POINTS))
    kept = np.unique(np.append(places, len(way) - 1).clip(max=len(way) - 1))
    return {
        "scenario": record.scenario.name,
        "speed_rpm": _listed(record.run.column("speed")[kept] / RADIANS_PER_RPM),
        "direct_current_a": _listed(direct[kept]),
        "quadrature_current_a": _listed(quadrature[kept]),
    }


def _points(record: DutyRecord) -> Iterator[dict[str, Any]]:
    base, rated = record.document.rating.base_speed_rpm, record.document.rating.rated_torque_nm
    for window in efficiency_windows(record):
        own, least = losses(record, window)
        required = window.dwell.speed_rpm / base, (window.torque_reference or 0.0) / rated
        speed, torque = min(EFFICIENCY_POINTS, key=lambda point: _distance(point, required))
        reached = efficiency(own, window.speed)
        known = isfinite(least.loss) and least.loss > 0.0
        yield {
            "speed_share": speed,
            "torque_share": torque,
            "speed_rpm": window.dwell.speed_rpm,
            "torque_nm": _rounded(own.torque),
            "direct_current_a": _rounded(own.direct),
            "quadrature_current_a": _rounded(own.quadrature),
            "loss_w": _rounded(own.loss),
            "least_loss_w": _rounded(least.loss) if known else None,
            "least_loss_direct_a": _rounded(least.direct) if known else None,
            "least_loss_quadrature_a": _rounded(least.quadrature) if known else None,
            "above_least_percent": round(100.0 * (own.loss / least.loss - 1.0), 3) + 0.0 if known else None,
            "efficiency_percent": None if reached is None else _rounded(reached),
        }


def _distance(point: tuple[float, float], other: tuple[float, float]) -> float:
    return max(abs(point[0] - other[0]), abs(point[1] - other[1]))


def _torque(record: DutyRecord) -> dict[str, Any] | None:
    """Follow the torque at rated torque and base speed; None where a turn takes too many control periods."""
    window = next(reversed([*efficiency_windows(record)]), None)
    if window is None:
        return None
    turn = 2.0 * np.pi / (record.document.machine.pole_pairs * window.speed)
    length = record.scenario.control_period_s
    turns = int(min(max(_FOLLOWED_PERIODS * length // turn, 1), _MOST_TURNS))
    count = round(turns * turn / length)
    if count > min(_MOST_PERIODS, round((window.end_s - window.start_s) / length)):
        return None
    course = torque_course(record, round(window.end_s / length) - count, count)
    # A faulty controller may give no torque at all.
    rated = record.document.rating.rated_torque_nm
    orders = int(_HIGHEST_CARRIERS * record.document.inverter.carrier_frequency_hz * count * length)
    percent = 100.0 * amplitudes(course.torque, orders) / rated
    frequency = np.arange(1, orders + 1) / (count * length)
    # Of neighbours that one point stands for, the greatest is shown.
    peaks = [begin + int(np.argmax(percent[begin:end])) for begin, end in _groups(orders)]
    one = [(begin, end) for begin, end in _groups(min(round(turn / length), count))]
    return {
        "speed_rpm": window.dwell.speed_rpm,
        "mean_nm": _rounded(course.torque.mean),
        "turns": turns,
        "electrical_frequency_hz": _rounded(1.0 / turn),
        "carrier_frequency_hz": record.document.inverter.carrier_frequency_hz,
        "peak_to_peak_percent": _rounded(100.0 * float(course.greatest.max() - course.least.min()) / rated),
        "angle_deg": _listed(np.array([360.0 * begin * length / turn for begin, _ in one])),
        "least_nm": _listed(np.array([course.least[begin:end].min() for begin, end in one])),
        "greatest_nm": _listed(np.array([course.greatest[begin:end].max() for begin, end in one])),
        "frequency_hz": _listed(frequency[peaks]),
        # Smaller ones are rounding, which need not be the same on every processor.
        "amplitude_percent": [round(float(value), _AMPLITUDE_PLACES) for value in percent[peaks]],
    }


def _groups(count: int) -> list[tuple[int, int]]:
    """Divide a number of neighbours into groups, few enough to be drawn."""
    size = max(-(-count // MOST_POINTS), 1)
    return [(begin, min(begin + size, count)) for begin in range(0, count, size)]


def _listed(values: NDArray[np.float64]) -> list[float]:
    return [_rounded(float(value)) or 0.0 for value in values]


def _rounded(value: float) -> float | None:
    # Far below what any of these quantities mean, where rounding alone is left; and no zero has a sign.
    return significant(round(value, 6), _DIGITS) + 0.0 if isfinite(value) else None
