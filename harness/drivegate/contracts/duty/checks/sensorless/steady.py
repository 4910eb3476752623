"""Checks of steady running without a position sensor: speed or torque, the estimated angle, and other parameters."""

from __future__ import annotations

from collections.abc import Iterable
from math import degrees

import numpy as np
from numpy.typing import NDArray

from drivegate.checks.check import Check
from drivegate.checks.course import course_of
from drivegate.checks.margin import Margin, Mark, Moment, Point, at_most
from drivegate.contracts.duty.checks.judged import SENSORLESS_ANGLE_DEG, at, decisive, is_within_reach, worst
from drivegate.contracts.duty.checks.sensorless.judged import (
    SPEED_FACTOR,
    TORQUE_SHARE,
    if_sensorless,
    is_sensorless,
    least_speed,
)
from drivegate.contracts.duty.checks.sensorless.measures import angle_errors, mean_and_peak_deg
from drivegate.contracts.duty.record import DutyRecord, DutyWindow
from drivegate.contracts.duty.scenarios.sensorless import WELL_ABOVE
from drivegate_models.units import RADIANS_PER_RPM

OTHER_FACTOR = 2.0
"""Error on another plant over that on the nominal one (1)."""
MEAN_DEG, PEAK_DEG, OTHER_DEG = SENSORLESS_ANGLE_DEG, 10.0, 15.0
"""Greatest mean and peak error of the angle, and both on another plant (electrical degrees)."""
_ROUNDING = 1e-9


def steady_without_sensor(record: DutyRecord) -> Margin | None:
    """Judge the means of a nominal drive that is seen as it is."""
    return worst(_error("SLS-2", record, window, 1.0) for window in _judged(record, 1.0) if record.is_nominal)


def steady_on_another_plant(record: DutyRecord) -> Margin | None:
    """Judge the means of a plant with other parameters than the nameplate's."""
    if record.has_nominal_plant or record.is_sensed or record.fails:
        return None
    return worst(_error("SLS-8", record, window, OTHER_FACTOR) for window in _judged(record, WELL_ABOVE))


def estimated_angle(record: DutyRecord) -> Margin | None:
    """Judge the controller's own angle where it gives one."""
    if record.is_sensed or record.fails:
        return None
    return worst(_angle_error(record, window) for window in _of_angle(record))


def _of_angle(record: DutyRecord) -> Iterable[DutyWindow]:
    return _judged(record, 1.0 if record.has_nominal_plant else WELL_ABOVE)


def angle_moment(record: DutyRecord) -> Moment | None:
    """Show the angle's error in the stretch that decides."""
    least = decisive((window, _angle_error(record, window)) for window in _of_angle(record))
    if least is None:
        return None
    window, _ = least
    rows, period = record.periods(window.start_s, window.end_s), record.scenario.control_period_s
    errors = np.array([degrees(error) for error in _errors_of(record, window)])
    times = (np.arange(rows.start, rows.stop) + 0.5) * period
    place = int(np.argmax(np.abs(errors)))
    greatest = PEAK_DEG if record.has_nominal_plant else OTHER_DEG
    return Moment(
        start_s=window.start_s,
        end_s=window.end_s,
        quantity="angle error (el. deg)",
        courses=(course_of("error", times, errors),),
        levels=tuple(Mark(words=f"± {greatest:g}°", value=value) for value in (greatest, -greatest)),
        point=Point(
            words=f"{abs(errors[place]):.3g}°",
            time_s=float(times[place]),
            value=float(errors[place]),
        ),
    )


def _errors_of(record: DutyRecord, window: DutyWindow) -> NDArray[np.float64]:
    """Return the errors of the angle in a stretch (rad), shape (n,)."""
    rows = record.periods(window.start_s, window.end_s)
    estimate, angle = record.run.commands["angle"][rows], record.run.column("angle")[rows]
    return angle_errors(estimate, angle, record.document.machine.pole_pairs)


def _judged(record: DutyRecord, factor: float) -> Iterable[DutyWindow]:
    """List the steady stretches from a multiple of the least speed on."""
    if not is_sensorless(record):
        return ()
    least = factor * least_speed(record) * (1.0 - _ROUNDING)
    return tuple(window for window in record.steady if abs(window.speed_reference) >= least)


def _error(check: str, record: DutyRecord, window: DutyWindow, factor: float) -> Margin | None:
    wanted = window.torque_reference
    if wanted is None:
        error = abs(window.speed - window.speed_reference) / RADIANS_PER_RPM
        allowed = factor * SPEED_FACTOR * record.limits.speed_tolerance_rpm
        return Margin(check, at_most(error, allowed), f"speed off by {error:.4g} rpm {at(window)}")
    if not is_within_reach(record, window.speed, window.link, wanted):
        return None
    error = abs(window.torque - wanted)
    allowed = factor * TORQUE_SHARE * record.document.rating.rated_torque_nm
    return Margin(
        check, at_most(error, allowed), f"torque off by {error:.4g} N·m from {wanted:.4g} N·m {at(window)}"
    )


def _angle_error(record: DutyRecord, window: DutyWindow) -> Margin | None:
    rows = record.periods(window.start_s, window.end_s)
    estimate = record.run.commands["angle"][rows]
    if not np.isfinite(estimate).all():
        return None
    mean, peak = mean_and_peak_deg(_errors_of(record, window))
    is_nominal = record.has_nominal_plant
    measured = f"angle off by {mean:.3g}° in the mean, {peak:.3g}° at most, {at(window)}"
    greatest = (MEAN_DEG, PEAK_DEG) if is_nominal else (OTHER_DEG, OTHER_DEG)
    margin = min(at_most(found, limit) for found, limit in zip((mean, peak), greatest, strict=True))
    # As long as SLS-8 only advises, so does its angle.
    return Margin("SLS-3", margin, measured, advisory=not is_nominal)


SLS_2 = Check(
    id="SLS-2",
    families=("sensorless load", "sensorless load step", "torque step", "flying start"),
    requirement=(
        "Without a position sensor, from the least speed to the highest one, either way and under -80 to 80 % of rated "
        "torque, the mean speed is within 2 k1 of its reference, or the mean torque within 5 % of rated torque."
    ),
    limit="speed 2 k1, torque 5 % of rated torque",
    scenarios="steady stretches of the nominal drive from the least speed on",
    formula="1 - |mean - reference| / limit",
    why="A rotor that is lost shows as a speed or a torque that is not the reference.",
    evaluate=steady_without_sensor,
    reason_not_applicable=if_sensorless,
)
SLS_3 = Check(
    id="SLS-3",
    families=(
        "sensorless load",
        "sensorless load step",
        "torque step",
        "flying start",
        "sensorless parameter",
    ),
    requirement=(
        "The controller's estimate of the shaft's angle, at the instant of the sample, is within 5° electrical in the "
        "mean and 10° at any time; within 15° on a plant that differs from the nameplate."
    ),
    limit="5° electrical in the mean, 10° at any time, 15° on another plant",
    scenarios="steady stretches from the least speed on, and on another plant from twice that speed on, in which every "
    "command has an angle; without one, SLS-2 alone judges these stretches",
    formula="the least of 1 - mean error / 5° and 1 - greatest error / 10°, or of 1 - error / 15°",
    why="The angle's error grows long before the rotor is lost.",
    evaluate=estimated_angle,
    moment=angle_moment,
    reason_not_applicable=if_sensorless,
)
SLS_8 = Check(
    id="SLS-8",
    families=("sensorless parameter",),
    requirement=(
        "Without a position sensor, from twice the least speed on, twice the limits of SLS-2 are met on plants with "
        "0.7 to 1.3 times the resistance, 0.9 to 1.05 times the magnet's flux, or 0.8 to 1.2 times the inductances."
    ),
    # foc-sensorless meets it on every included drive. What is required needs a seeded fault, which it has none of yet.
    level="advisory",
    limit="speed 4 k1, torque 10 % of rated torque",
    scenarios="steady stretches of plants that differ from the nameplate",
    formula="1 - |mean - reference| / limit",
    why="Copper warms up, magnets weaken, and data sheets are 20 % off.",
    evaluate=steady_on_another_plant,
    reason_not_applicable=if_sensorless,
)
