"""Checks of a plant that differs from the nameplate, and of sensors that show it with errors."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, at_most
from drivegate.checks.record import Record
from drivegate.contracts.duty.checks.accuracy import reference_error
from drivegate.contracts.duty.checks.judged import at, duty_record, worst
from drivegate.contracts.duty.record import DutyRecord, DutyWindow
from drivegate.contracts.duty.scenarios.position_errors import lost_torque_share
from drivegate_models.units import RADIANS_PER_RPM

ERROR_FACTOR = 2.0
"""Error of the speed over that which is allowed on the nominal drive (1)."""
OVERSHOOT = 0.25
"""Greatest overshoot of the speed over its step (1)."""
GROWTH = 1.5
"""Greatest ratio of the speed's swing at the end of a steady stretch to that at its begin (1)."""


def another_plant(record: Record) -> Margin | None:
    """Judge runs of a speed reference whose plant the controller does not know."""
    judged = duty_record(record)
    if judged.has_nominal_plant or judged.fails:
        return None
    return worst(_margins(judged))


def _margins(record: DutyRecord) -> Iterator[Margin]:
    speed = record.run.column("speed") / RADIANS_PER_RPM
    before = record.scenario.initial_speed_rpm
    period = record.scenario.control_period_s
    for window in record.steady:
        if window.torque_reference is not None:
            continue
        error = reference_error("ROB-4", record, window, ERROR_FACTOR)
        if error is not None:
            yield error
        yield _swing(record, window)
        step = window.dwell.speed_rpm - before
        before = window.dwell.speed_rpm
        if step != 0.0:
            rows = slice(round(window.dwell.start / period), round(window.dwell.end / period))
            over = max(float(np.max((speed[rows] - window.dwell.speed_rpm) / step)), 0.0)
            told = f"speed overshoots by {100.0 * over:.3g} % of its step of {step:.4g} rpm"
            yield Margin("ROB-4", at_most(over, OVERSHOOT), told)


def _swing(record: DutyRecord, window: DutyWindow) -> Margin:
    """Judge whether what swings about the mean grows; below the allowed error it may do what it likes."""
    period = record.scenario.control_period_s
    values = record.run.column("speed")[round(window.start_s / period) : round(window.end_s / period)]
    half = len(values) // 2
    allowed = record.limits.speed_tolerance_rpm * RADIANS_PER_RPM
    first, last = (max(float(np.ptp(part)), allowed) for part in (values[:half], values[half:]))
    told = f"speed swings by {last / RADIANS_PER_RPM:.4g} rpm, {last / first:.3g} times as much as before, {at(window)}"
    return Margin("ROB-4", at_most(last / first, GROWTH), told)


def through_sensors(record: Record) -> Margin | None:
    """Judge runs whose controller sees currents, link and shaft through sensors."""
    judged = duty_record(record)
    if not judged.is_sensed or not judged.has_nominal_plant or judged.fails:
        return None
    lost = lost_torque_share(judged.scenario)
    errors = (reference_error("ROB-5", judged, window, ERROR_FACTOR, lost) for window in judged.steady)
    return worst(error for error in errors if error is not None)


ROB_4 = Check(
    id="ROB-4",
    families=("parameter",),
    requirement="On a plant that differs from the nameplate the speed is held, and nothing grows.",
    source="the contract",
    level="required",
    limit="speed error 2 k1, overshoot 25 %, swing × 1.5",
    scenarios="runs of a speed reference with R × 0.5 to 2, L × 0.7 to 1.3, ψ × 0.8 to 1.05 and J × 0.3 to 2",
    formula="the least of 1 - speed error / 2 k1, 1 - overshoot / 25 % and 1 - growth of the swing / 1.5",
    why="Windings warm up, iron saturates, magnets age, loads have inertia of their own; the nameplate stays.",
    evaluate=another_plant,
)

ROB_5 = Check(
    id="ROB-5",
    families=("sensor", "position error", "lost sample", "false edge"),
    requirement="Through shunts, converters and an encoder or Hall switches the reference is held, also after lost "
    "samples and false edges.",
    source="the contract",
    level="required",
    limit="torque 2 × {torque_error} and what an error of the angle costs, speed error 2 k1",
    scenarios="steady stretches of runs with the sensors 'shunts', single samples that are lost, or false edges, "
    "torques up to {weakening} of the greatest possible",
    formula="1 - |mean - reference| / twice the limit of ACC-1",
    why="Firmware sees the currents through amplifiers with offsets, and the shaft in edges.",
    evaluate=through_sensors,
)
