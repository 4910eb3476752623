"""Checks of the referenced quantity in steady state: as the nameplate says, and through real sensors."""

from __future__ import annotations

from dataclasses import replace

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, at_most
from drivegate.checks.means import exact_mean
from drivegate.contracts.duty.checks.judged import (
    UNWEAKENED_FAMILIES,
    at,
    is_within_reach,
    unless_sensed,
    worst,
)
from drivegate.contracts.duty.record import DutyRecord, DutyWindow
from drivegate.contracts.duty.right_trips import legs_are_off
from drivegate.contracts.duty.scenarios.drawn_range import lost_torque_share
from drivegate.contracts.duty.scenarios.windows import is_held, settling_s
from drivegate_models.units import RADIANS_PER_RPM

ERROR_FACTOR = 2.0
"""Error of the speed over that which is allowed on the nominal drive (1)."""
BRIDGE_OFF = "where the controller has turned all legs off"
"""Words for a stretch without a torque by the controller."""
SETTLES = 0.9
"""Error in the second half of a window, over that in the first half, below which it is still settling (1)."""


def steady_reference(record: DutyRecord) -> Margin | None:
    released = record.released if record.is_nominal else ()
    return worst(reference_error("ACC-1", record, window, 1.0) for window in (*record.nominal, *released))


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
        found = f"speed off by {error:.4g} rpm {at(window)}"
        return _judged(record, window, Margin(check, margin, found), "speed", window.speed_reference)
    if not is_within_reach(record, window.speed, window.link, wanted):
        return None
    if record.follows_current:
        rated_torque = record.document.rating.rated_torque_nm
        current, rated = (record.quadrature_reference(torque) for torque in (wanted, rated_torque))
        error = abs(window.quadrature - current)
        allowed = factor * rated * limits.torque_error_nm / rated_torque
        margin = at_most(error, allowed + lost_share * abs(current))
        found = f"q current off by {error:.4g} A from {current:.4g} A {at(window)}"
        return _judged(record, window, Margin(check, margin, found), "quadrature", current)
    error = abs(window.torque - wanted)
    lost_share += lost_between_samples(record, window)
    margin = at_most(error, factor * limits.torque_error_nm + lost_share * abs(wanted))
    found = f"torque off by {error:.4g} N·m from {wanted:.4g} N·m {at(window)}"
    return _judged(record, window, Margin(check, margin, found), "torque", wanted)


def lost_between_samples(record: DutyRecord, window: DutyWindow) -> float:
    """Return the share of its torque at samples that a machine lacks on average between them (1).

    Duty ratios stand still while the rotor turns by an angle x. In its frame the voltage v that keeps the currents
    turns by x from half of it ahead to half of it behind, so that they are off by ``j w v (t T - t**2) / (2 L)`` at a
    time t of a control period T, on average by ``j w v T**2 / (12 L)``: the q current by x**2 / 12 of itself.
    """
    turned = record.plant.pole_pairs * window.speed * record.scenario.control_period_s
    return turned * turned / 12.0


def _judged(record: DutyRecord, window: DutyWindow, margin: Margin, column: str, wanted: float) -> Margin:
    """Name a bridge that is off, or the settling time where what is off still comes nearer at the end of it."""
    if margin.met:
        return margin
    commands = record.run.commands[record.periods(window.start_s, window.end_s)]
    if legs_are_off(commands).all():
        code = int(commands["fault"][-1])
        return replace(margin, measured=f"{margin.measured}, {BRIDGE_OFF}, with the fault code {code}")
    values = record.run.column(column)[record.periods(window.start_s, window.end_s)]
    half = len(values) // 2
    first, last = (abs(exact_mean(part) - wanted) for part in (values[:half], values[half:]))
    if last >= SETTLES * first:
        return margin
    settling = settling_s(record.document, held=is_held(record.scenario))
    late = f"{margin.measured}, and still settling: requirements.settling_s is {settling:g} s"
    return replace(margin, measured=late)


ACC_1 = Check(
    id="ACC-1",
    families=(*UNWEAKENED_FAMILIES, "overspeed", "released"),
    requirement=(
        "In steady state, and on a shaft that a torque turns freely, the mean torque is within {torque_error} "
        "of its reference, and the mean speed within k1 = {k1}."
    ),
    limit="torque {torque_error} and what is lost between samples, speed k1 = {k1}",
    scenarios="steady stretches of the nominal drive, and those of a shaft that is released; torques up "
    "to {weakening} of the greatest possible",
    formula="1 - |mean - reference| / limit",
    why="What is above the current loop relies on it.",
    evaluate=steady_reference,
    # Without a sensor, SLS-2 has limits of its own.
    reason_not_applicable=unless_sensed,
)


def through_sensors(record: DutyRecord) -> Margin | None:
    if not record.is_sensed or not record.has_nominal_plant or record.fails:
        return None
    lost = lost_torque_share(record.scenario)
    return worst(reference_error("ROB-5", record, window, ERROR_FACTOR, lost) for window in record.steady)


ROB_5 = Check(
    id="ROB-5",
    families=("sensor", "position error", "lost sample", "false edge", "joint change"),
    requirement=(
        "Through shunts, converters and an encoder or Hall switches, also after lost samples and false edges, "
        "the mean torque is within 2 × {torque_error} and what an error of the angle costs, and the mean "
        "speed within 2 k1."
    ),
    limit="torque 2 × {torque_error} and what an error of the angle costs, speed error 2 k1",
    scenarios="steady stretches of runs with the sensors 'shunts', single samples that are lost, or false edges, "
    "torques up to {weakening} of the greatest possible",
    formula="1 - |mean - reference| / twice the limit of ACC-1",
    why="Firmware sees the currents through amplifiers with offsets, and the shaft in edges.",
    evaluate=through_sensors,
    reason_not_applicable=unless_sensed,
)
