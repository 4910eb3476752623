"""Checks of the referenced quantity in steady state: as the nameplate says, on another plant, through real sensors."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, at_most
from drivegate.contracts.duty.checks.judged import UNWEAKENED_FAMILIES, at, is_within_reach, worst
from drivegate.contracts.duty.checks.steps import overshoot_of
from drivegate.contracts.duty.record import DutyRecord, DutyWindow
from drivegate.contracts.duty.scenarios.drawn_range import lost_torque_share
from drivegate_models.units import RADIANS_PER_RPM

ERROR_FACTOR = 2.0
"""Error of the speed over that which is allowed on the nominal drive (1)."""
OVERSHOOT = 0.25
"""Greatest overshoot of the speed over the way that it came (1)."""
GROWTH = 1.5
"""Greatest ratio of the speed's swing at the end of a steady stretch to that at its begin (1)."""


def steady_reference(record: DutyRecord) -> Margin | None:
    return worst(reference_error("ACC-1", record, window, 1.0) for window in record.nominal)


def reference_error(
    check: str, record: DutyRecord, window: DutyWindow, factor: float, lost_share: float = 0.0
) -> Margin | None:
    """Judge the mean of the referenced quantity in a window, by a multiple of its limit; None out of reach.

    `lost_share` is the share of a torque that its controller cannot know to be lost.
    """
    limits, wanted = record.limits, window.torque_reference
    if wanted is None:
        error = abs(window.speed - window.speed_reference) / RADIANS_PER_RPM
        margin = at_most(error, factor * limits.speed_tolerance_rpm)
        return Margin(check, margin, f"speed off by {error:.4g} rpm {at(window)}")
    if not is_within_reach(record, window.speed, window.link, wanted):
        return None
    if record.follows_current:
        rated_torque = record.document.rating.rated_torque_nm
        current, rated = (record.quadrature_reference(torque) for torque in (wanted, rated_torque))
        error = abs(window.quadrature - current)
        allowed = factor * rated * limits.torque_error_nm / rated_torque
        margin = at_most(error, allowed + lost_share * abs(current))
        return Margin(check, margin, f"q current off by {error:.4g} A from {current:.4g} A {at(window)}")
    error = abs(window.torque - wanted)
    margin = at_most(error, factor * limits.torque_error_nm + lost_share * abs(wanted))
    return Margin(check, margin, f"torque off by {error:.4g} N·m from {wanted:.4g} N·m {at(window)}")


ACC_1 = Check(
    id="ACC-1",
    families=UNWEAKENED_FAMILIES,
    requirement="In steady state the mean torque or speed is the reference.",
    limit="torque {torque_error}, speed k1 = {k1}",
    scenarios="steady stretches of the nominal drive, torques up to {weakening} of the greatest possible",
    formula="1 - |mean - reference| / limit",
    why="What is above the current loop relies on it.",
    evaluate=steady_reference,
)


def another_plant(record: DutyRecord) -> Margin | None:
    if record.has_nominal_plant or record.fails:
        return None
    return worst(_margins(record))


def _margins(record: DutyRecord) -> Iterator[Margin | None]:
    speed = record.run.column("speed") / RADIANS_PER_RPM
    before = record.scenario.initial_speed_rpm
    for window in record.steady:
        if window.torque_reference is not None:
            continue
        yield reference_error("ROB-4", record, window, ERROR_FACTOR)
        yield _swing(record, window)
        step = window.dwell.speed_rpm - before
        before = window.dwell.speed_rpm
        if step != 0.0:
            rows = record.periods(window.dwell.start, window.dwell.end)
            yield overshoot_of_speed(speed[rows], window.dwell.speed_rpm, step)


def overshoot_of_speed(speed: NDArray[np.float64], end: float, step: float) -> Margin:
    """Judge how far the speed goes beyond the end of a step of its reference (rpm), over the way that it came.

    That is the signed step (rpm), or more where a load that comes on takes the speed farther away first.
    """
    beyond = (speed - end) / step
    way = step * max(1.0, -float(np.min(beyond[: int(np.argmax(beyond)) + 1])))
    over = overshoot_of(speed, end, way)
    measured = f"speed overshoots by {100.0 * over:.3g} % of the {abs(way):.4g} rpm that it came"
    return Margin("ROB-4", at_most(over, OVERSHOOT), measured)


def _swing(record: DutyRecord, window: DutyWindow) -> Margin:
    """Judge whether what swings about the mean grows; below the allowed error it may do what it likes."""
    values = record.run.column("speed")[record.periods(window.start_s, window.end_s)]
    half = len(values) // 2
    allowed = record.limits.speed_tolerance_rpm * RADIANS_PER_RPM
    first, last = (max(float(np.ptp(part)), allowed) for part in (values[:half], values[half:]))
    growth = last / first
    measured = f"speed swings by {last / RADIANS_PER_RPM:.4g} rpm, {growth:.3g} times as much as before, {at(window)}"
    return Margin("ROB-4", at_most(growth, GROWTH), measured)


def through_sensors(record: DutyRecord) -> Margin | None:
    if not record.is_sensed or not record.has_nominal_plant or record.fails:
        return None
    lost = lost_torque_share(record.scenario)
    return worst(reference_error("ROB-5", record, window, ERROR_FACTOR, lost) for window in record.steady)


ROB_4 = Check(
    id="ROB-4",
    families=("parameter",),
    requirement="On a plant that differs from the nameplate the speed is held, and nothing grows.",
    limit="speed error 2 k1, overshoot 25 %, swing × 1.5",
    scenarios="runs of a speed reference with R × 0.5 to 2, L × 0.7 to 1.3, ψ × 0.8 to 1.05 and J × 0.3 to 2, "
    "also within a run, as of a wheel that is lifted and set down",
    formula="the least of 1 - speed error / 2 k1, 1 - overshoot / 25 % and 1 - growth of the swing / 1.5",
    why="Windings warm up, iron saturates, magnets age, loads have inertia of their own; the nameplate stays.",
    evaluate=another_plant,
)

ROB_5 = Check(
    id="ROB-5",
    families=("sensor", "position error", "lost sample", "false edge", "joint change"),
    requirement="Through shunts, converters and an encoder or Hall switches the reference is held, also after lost "
    "samples and false edges.",
    limit="torque 2 × {torque_error} and what an error of the angle costs, speed error 2 k1",
    scenarios="steady stretches of runs with the sensors 'shunts', single samples that are lost, or false edges, "
    "torques up to {weakening} of the greatest possible",
    formula="1 - |mean - reference| / twice the limit of ACC-1",
    why="Firmware sees the currents through amplifiers with offsets, and the shaft in edges.",
    evaluate=through_sensors,
)
