"""Check of a lost rotor without a position sensor: locked, or stopped by a load that is too great."""

from __future__ import annotations

from math import isfinite
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, Mark, Moment, Point, at_most
from drivegate.checks.stretches import lasting_from
from drivegate.contracts.duty.checks.judged import worst
from drivegate.contracts.duty.checks.sensorless.judged import if_speed, least_speed, regulates_speed
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.right_trips import legs_are_low, legs_are_off
from drivegate.contracts.duty.scenarios.overload import overloaded_s
from drivegate.contracts.duty.scenarios.sensorless import LOSS_S
from drivegate_cases.drive.pm_ac.greatest_torque import greatest_within
from drivegate_models.pm_ac.oracle import undistorted_limits

SWING = 1.2
"""Greatest torque of a lost rotor over that of the current limit (1)."""
STOPPED = 0.01
"""Speed of a shaft that an overload has stopped, over the least one (1)."""


class _Loss(NamedTuple):
    """What loses the rotor."""

    words: str
    begin: int
    """Control period from which on the torque is judged."""
    first: int
    """Control period in which the rotor is lost, from which the time counts."""
    allowed_s: float
    """Time in which it has to be reported (s)."""

    def at(self, record: DutyRecord) -> str:
        return f"{self.words} at {self.first * record.scenario.control_period_s:.4g} s"


def _loss(record: DutyRecord) -> _Loss | None:
    scenario, failure = record.scenario, record.scenario.failure
    if not regulates_speed(record) or not record.has_nominal_plant or record.is_sensed:
        return None
    if failure is not None:
        return _lock(record) if failure.kind == "locked-rotor" else None
    begin, _ = overloaded_s(scenario)
    if not isfinite(begin):
        return None
    row = round(begin / scenario.control_period_s)
    slow = np.abs(record.run.column("speed")) < STOPPED * least_speed(record)
    stopped = max(row, lasting_from(slow))
    return _Loss("the overload stops the shaft", row, stopped, LOSS_S)


def _lock(record: DutyRecord) -> _Loss:
    scenario, failure = record.scenario, record.scenario.failure
    assert failure is not None, "a shaft that locks"
    first = failure.first_period(scenario.control_period_s)
    # A start may be tried twice.
    starts = failure.time_s == 0.0 and scenario.initial_speed_rpm == 0.0
    allowed = LOSS_S + (2.0 * record.document.start_time_s if starts else 0.0)
    return _Loss("the lock", first, first, allowed)


def lost_rotor(record: DutyRecord) -> Margin | None:
    """Judge the time in which a controller reports that the rotor is lost, and the torque until then."""
    if (loss := _loss(record)) is None:
        return None
    period, reported = record.scenario.control_period_s, _reported(record)
    if len(reported) - loss.first < loss.allowed_s / period:
        return None
    count = lasting_from(reported[loss.first :])
    time = count * period
    verb = "reported" if loss.first + count < len(reported) else "not reported"
    words = f"{verb} {time:.4g} s after {loss.at(record)}"
    greatest = float(np.max(np.abs(record.run.column("torque")[loss.begin :])))
    limits = undistorted_limits(record.plant, float(record.run.column("link")[loss.begin]))
    most = SWING * greatest_within(record.plant, limits, 0.0, weakens=True).torque
    return worst(
        (
            Margin("SLS-7", at_most(time, loss.allowed_s), words),
            Margin("SLS-7", at_most(greatest, most), f"torque {greatest:.4g} N·m at a lost rotor"),
        )
    )


def lost_moment(record: DutyRecord) -> Moment | None:
    """Show the torque from the loss on, until it is reported or the greatest."""
    margin, loss = lost_rotor(record), _loss(record)
    if margin is None or loss is None:
        return None
    period, torque = record.scenario.control_period_s, record.run.column("torque")
    if "reported" in margin.measured:
        begin = loss.first
        place = min(begin + lasting_from(_reported(record)[begin:]), len(torque) - 1)
    else:
        begin = loss.begin
        place = begin + int(np.argmax(np.abs(torque[begin:])))
    start, time, allowed = begin * period, (place + 0.5) * period, loss.allowed_s
    return Moment(
        start_s=start,
        end_s=min(max(start + 1.5 * allowed, time + 0.1 * allowed), record.scenario.duration_s),
        column="torque_nm",
        origin_s=start,
        instants=(Mark(words=f"{allowed:.3g} s allowed", value=loss.first * period + allowed),),
        point=Point(
            words=margin.measured.partition(" after")[0].partition(" at")[0],
            time_s=time,
            value=float(torque[place]),
        ),
    )


def _reported(record: DutyRecord) -> NDArray[np.bool_]:
    """Return in which control periods a lost rotor is reported, shape (n,)."""
    commands = record.run.commands
    is_safe = legs_are_off(commands) | legs_are_low(commands)
    reported: NDArray[np.bool_] = (commands["fault"] != 0) & is_safe
    return reported


SLS_7 = Check(
    id="SLS-7",
    families=("lost rotor",),
    requirement=(
        "Without a position sensor, a rotor that locks, or that an overload stops, is reported by a fault code within "
        "500 ms, with all legs off or all low; one that is locked before a start, after twice the start time more. "
        "Until then the torque is at most 1.2 times that of the current limit."
    ),
    limit="500 ms, twice the start time more before a start; 1.2 times the torque of the current limit",
    scenarios="runs of the nominal drive whose shaft locks before a start, or at a steady speed under a load, or is "
    "stopped by a load that rises to 1.5 times the greatest torque",
    formula="the lesser of 1 - time until it is reported for good / limit and 1 - greatest torque / limit",
    why="A start that goes on for ever before a locked rotor burns the winding.",
    evaluate=lost_rotor,
    moment=lost_moment,
    reason_not_applicable=if_speed,
)
