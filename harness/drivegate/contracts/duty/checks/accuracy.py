"""Check of the referenced quantity in steady state."""

from __future__ import annotations

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, at_most
from drivegate.checks.record import Record
from drivegate.contracts.duty.checks.judged import (
    UNWEAKENED_FAMILIES,
    at,
    duty_record,
    is_within_reach,
    worst,
)
from drivegate.contracts.duty.record import DutyRecord, DutyWindow
from drivegate_models.units import RADIANS_PER_RPM


def steady_reference(record: Record) -> Margin | None:
    """Judge the mean of the referenced quantity on the nominal drive."""
    judged = duty_record(record)
    if not judged.is_nominal:
        return None
    margins = [reference_error("ACC-1", judged, window, 1.0) for window in judged.steady]
    return worst(margin for margin in margins if margin is not None)


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
        current, rated = (record.quadrature_reference(torque) for torque in (wanted, limits.rated_torque_nm))
        error = abs(window.quadrature - current)
        allowed = factor * rated * limits.torque_error_nm / limits.rated_torque_nm
        margin = at_most(error, allowed + lost_share * abs(current))
        return Margin(check, margin, f"q current off by {error:.4g} A from {current:.4g} A {at(window)}")
    error = abs(window.torque - wanted)
    margin = at_most(error, factor * limits.torque_error_nm + lost_share * abs(wanted))
    return Margin(check, margin, f"torque off by {error:.4g} N·m from {wanted:.4g} N·m {at(window)}")


ACC_1 = Check(
    id="ACC-1",
    families=UNWEAKENED_FAMILIES,
    requirement="In steady state the mean torque or speed is the reference.",
    source="the contract",
    level="required",
    limit="torque {torque_error}, speed k1 = {k1}",
    scenarios="steady stretches of the nominal drive, torques up to {weakening} of the greatest possible",
    formula="1 - |mean - reference| / limit",
    why="What is above the current loop relies on it.",
    evaluate=steady_reference,
)
