"""Check of what a controller does when a part of its drive fails."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.declaration import Declaration
from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, Mark, Moment, Point, at_most
from drivegate.checks.stretches import lasting_from
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.right_trips import claimed_safe, legs_are_low
from drivegate.contracts.duty.scenarios.drawn_range import unnoticed_because
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.failure import SURVIVABLE
from drivegate_cases.scenario.load import DynamometerLoad


def safe_state(record: DutyRecord) -> Margin | None:
    failure, period = record.scenario.failure, record.scenario.control_period_s
    if failure is None or failure.kind not in record.declaration.detects or not record.has_nominal_plant:
        return None
    if unnoticed_because(record.scenario) is not None:
        return None
    begin = failure.first_period(period)
    if failure.kind in SURVIVABLE and not isinstance(record.scenario.load, DynamometerLoad):
        # What torque a speed regulator wants, nobody else knows, and the speed hardly shows it.
        return None
    claimed = _claimed(record)
    if len(claimed) - begin < _longest_s(record) / period:
        return None
    if claimed[:begin].any():
        early = float(np.argmax(claimed)) * period
        return Margin("SAF-1", -1.0, f"the safe state is taken at {early:.4g} s, before anything fails")
    if failure.kind in SURVIVABLE and not claimed.any():
        return _ridden_through(record, begin)
    return min(
        _reached(record, claimed, begin),
        _torque_until_then(record, claimed, begin),
        key=lambda margin: margin.value,
    )


def failure_moment(record: DutyRecord) -> Moment | None:
    """Show the torque from the failure on, until twice the time that is allowed or what was measured."""
    failure, period = record.scenario.failure, record.scenario.control_period_s
    margin = safe_state(record)
    if failure is None or margin is None:
        return None
    begin, longest = failure.first_period(period) * period, _longest_s(record)
    claimed, torque = _claimed(record), record.run.column("torque")
    first = failure.first_period(period)
    if claimed[:first].any():
        place = int(np.argmax(claimed))
    elif failure.kind in SURVIVABLE and not claimed.any():
        place = first + int(np.argmax(np.abs(torque - record.run.column("torque_reference"))[first:]))
    elif _reached(record, claimed, first).value <= margin.value:
        place = min(first + round(_unsafe_s(record, claimed, first) / period), len(torque) - 1)
    else:
        place = first + int(np.argmax(_beyond(record, claimed, first)))
    reached = (place + 0.5) * period
    allowed = record.limits.failure_torque_nm
    wanted = record.run.column("torque_reference")[failure.first_period(period) - 1]
    levels = [Mark(words=f"± {allowed:.3g} N·m", value=value) for value in (allowed, -allowed)]
    if isinstance(record.scenario.load, DynamometerLoad):
        levels.append(Mark(words="reference", value=float(wanted)))
    return Moment(
        start_s=max(min(begin - 0.25 * longest, reached - longest), 0.0),
        end_s=min(max(begin + 2.0 * longest, reached + longest), record.scenario.duration_s),
        column="torque_nm",
        origin_s=begin,
        levels=tuple(levels),
        instants=(Mark(words=f"{1e3 * longest:.3g} ms allowed", value=begin + longest),),
        point=Point(
            words=margin.measured.partition(" after ")[0], time_s=reached, value=float(torque[place])
        ),
    )


def _claimed(record: DutyRecord) -> NDArray[np.bool_]:
    """Return in which control periods the controller says that it is in a safe state, shape (n,)."""
    claimed: NDArray[np.bool_] = claimed_safe(record.run.commands) | _is_shorted(record)
    return claimed


def _is_shorted(record: DutyRecord) -> NDArray[np.bool_]:
    """Return where all legs are low while the EMF would charge the link beyond its limit, shape (n,).

    Legs that are off are no safe state then: the diodes charge the capacitor. The torque is that of the short circuit.
    """
    commands, link = record.run.commands, record.document.real_link
    if link is None:
        return np.zeros(len(commands), np.bool_)
    induced = math.sqrt(3.0) * record.plant.magnet_flux * record.plant.pole_pairs
    shorted: NDArray[np.bool_] = legs_are_low(commands) & (
        induced * np.abs(record.run.column("speed")) > record.plant.dc_link.limit
    )
    return shorted


def _longest_s(record: DutyRecord) -> float:
    """Return the longest time from the failure of a run to the safe state (s)."""
    failure, limits = record.scenario.failure, record.limits
    locks = failure is not None and failure.kind == "locked-rotor"
    return limits.safe_state_locked_s if locks else limits.safe_state_s


def _ridden_through(record: DutyRecord, begin: int) -> Margin:
    """Judge the torque of a drive that goes on: it stays at its reference."""
    torque, wanted = (record.run.column(name)[begin:] for name in ("torque", "torque_reference"))
    greatest = float(np.max(np.abs(torque - wanted)))
    measured = f"torque {greatest:.4g} N·m off its reference after {_words(record)}"
    return Margin("SAF-1", at_most(greatest, record.limits.failure_torque_nm), measured)


def _reached(record: DutyRecord, claimed: NDArray[np.bool_], begin: int) -> Margin:
    period, time = record.scenario.control_period_s, _unsafe_s(record, claimed, begin)
    reached = begin + round(time / period) < len(claimed)
    measured = f"safe {1e3 * time:.4g} ms after" if reached else f"not safe {1e3 * time:.4g} ms after"
    return Margin("SAF-1", at_most(time, _longest_s(record)), f"{measured} {_words(record)}")


def _unsafe_s(record: DutyRecord, claimed: NDArray[np.bool_], begin: int) -> float:
    """Return the time from the failure on after which the drive is safe for good (s)."""
    still = np.abs(record.run.column("torque")) <= record.limits.failure_torque_nm
    still = still | _is_shorted(record)
    return lasting_from((claimed & still)[begin:]) * record.scenario.control_period_s


def _torque_until_then(record: DutyRecord, claimed: NDArray[np.bool_], begin: int) -> Margin:
    """Judge the torque beyond the reference or against it: less of it is what a safe state comes to."""
    limits = record.limits
    if not isinstance(record.scenario.load, DynamometerLoad):
        # What torque a speed regulator wants, nobody else knows.
        return Margin("SAF-1", 1.0, f"no torque is asked for {_words(record)}")
    greatest = max(float(np.max(_beyond(record, claimed, begin))), 0.0)
    measured = f"torque {greatest:.4g} N·m beyond its reference after {_words(record)}"
    return Margin("SAF-1", at_most(greatest, limits.failure_torque_nm), measured)


def _beyond(record: DutyRecord, claimed: NDArray[np.bool_], begin: int) -> NDArray[np.float64]:
    """Return the torque beyond the reference or against it in each control period until the safe state (N·m)."""
    later = np.flatnonzero(claimed[begin:])
    allowed = round(_longest_s(record) / record.scenario.control_period_s)
    rows = slice(begin, begin + 1 + (int(later[0]) if later.size else allowed))
    torque, wanted = (record.run.column(name)[rows] for name in ("torque", "torque_reference"))
    beyond: NDArray[np.float64] = np.maximum(
        torque - np.maximum(wanted, 0.0), np.minimum(wanted, 0.0) - torque
    )
    return beyond


def _words(record: DutyRecord) -> str:
    failure = record.scenario.failure
    assert failure is not None, "something fails in such a run"
    return f"{failure.kind} at {failure.time_s:.4g} s"


def _detects_nothing(declaration: Declaration, _drive: DriveDocument) -> str | None:
    return None if declaration.detects else "the candidate does not declare any failure that it detects"


SAF_1 = Check(
    id="SAF-1",
    families=("failure",),
    requirement=(
        "After each failure that the candidate declares to detect, the drive reaches a safe state within {safe_time} "
        "and stays in it. Until then its torque exceeds the reference by at most {failure_torque}. After a lost edge "
        "of the position, the controller may instead keep following the reference within {failure_torque}."
    ),
    limit="{safe_time}, and torque {failure_torque} until then and from then on, or throughout where it keeps running",
    scenarios=(
        "runs of the nominal drive in which a phase, a current sensor, the position or the shaft fails, an edge of the "
        "position is lost, or its magnet slips by 45 electrical degrees or more"
    ),
    formula=(
        "the lesser of 1 - time / {safe_time} and 1 - torque beyond 0 to the reference / {failure_torque}; of a drive "
        "that keeps running 1 - torque off the reference / {failure_torque}"
    ),
    why="What fails, fails in the field, where the torque that nobody asked for moves something.",
    evaluate=safe_state,
    moment=failure_moment,
    reason_not_applicable=_detects_nothing,
)
