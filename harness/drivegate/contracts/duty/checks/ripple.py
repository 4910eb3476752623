"""Checks of the torque ripple: over that of ideal modulation, and with dead time over that without."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import ceil, inf, isfinite, pi
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.declaration import NOTHING_DECLARED
from drivegate.checks.check import Check
from drivegate.checks.course import course_of
from drivegate.checks.margin import Course, Margin, Mark, Moment, Point, at_most
from drivegate.checks.means import exact_mean
from drivegate.contracts.duty.checks.judged import at, chopper_burns, decisive, undistorted, worst
from drivegate.contracts.duty.record import DutyRecord, DutyWindow
from drivegate.contracts.duty.right_trips import legs_are_off
from drivegate.contracts.duty.run import DUTY_RATIOS, LEGS
from drivegate_models.contract.duty.signals import LEG_HIGH, LEG_LOW
from drivegate_models.pm_ac.fundamental import steady_state
from drivegate_models.pm_ac.ideal_ripple import has_ideal_switches, ideal_swing, spread_samples
from drivegate_models.pm_ac.modulation_kind import MODULATION_NUMBERS, ONE_SIDED
from drivegate_models.pm_ac.ripple import NONE_KEPT, commanded_swing
from drivegate_models.units import RADIANS_PER_RPM

LEAST_TORQUE_SHARE: Final = 0.1
"""Torque over the rated one from which on ripple is judged (1)."""
LEAST_SPEED_SHARE: Final = 0.05
"""Speed over base speed from which on it is judged (1)."""
HELD_SHARE: Final = 0.05
"""Greatest distance of the speed from its reference, over base speed: ripple of a stalling shaft says nothing (1)."""
VOLTAGE_SHARE: Final = 0.95
"""Share of the undistorted voltage up to which it is judged: at the limit there is no ideal modulation (1)."""
LEAST_VOLTAGE_SHARE: Final = 0.01
"""Share of it from which on it is judged: without voltage, as in an active short, modulation has no ripple (1)."""
LEAST_SWING_SHARE: Final = 0.005
"""Swing of the torque over rated torque that is always allowed: a speed read in steps moves the torque by less (1)."""
LEAST_IDEAL_PERIODS: Final = 240
"""Control periods of the ideal that are looked at: what is rounded differs by where samples lie in a cycle."""
CLAMPED_RATIO: Final = 0.005
"""Distance of a duty ratio from 0 or 1 up to which its leg counts as clamped (1)."""
CLAMPED_SHARE: Final = 0.8
"""Share of the control periods with a clamped leg from which on the modulation looks discontinuous (1)."""
_Pair: TypeAlias = "tuple[tuple[DutyRecord, DutyWindow], tuple[DutyRecord, DutyWindow]]"
"""A window of the run with dead time and the same one of the run without."""
_SIXTH: Final = pi / 3.0
_FEWEST, _MOST = 20, 600
_LEAD: Final = 4
_TIME_CONSTANTS: Final = 2.0
_LONGEST: Final = 2000
_HINT: Final = (
    "a leg is clamped nearly always: if that is its modulation, declare it by the key 'modulation' of the manifest, "
    "such as modulation = 'dpwm-1'"
)


def _part(record: DutyRecord) -> float:
    """Return the part of a cycle after which the torque repeats itself (rad electrical): a sixth, or a third."""
    return _SIXTH * (2.0 if record.declaration.modulation in ONE_SIDED else 1.0)


def _watched(record: DutyRecord, window: DutyWindow) -> int:
    """Return the control periods in which the swing of the torque is measured."""
    length = record.scenario.control_period_s
    turning = record.document.machine.pole_pairs * abs(window.speed) * length
    available = round((window.end_s - window.start_s) / length) - _LEAD
    return min(max(ceil(_part(record) / turning), _FEWEST), _MOST, available)


def _swing(record: DutyRecord, window: DutyWindow, extremes: NDArray[np.float64] = NONE_KEPT) -> float:
    """Return the greatest less the least torque at any instant of the end of a window (N·m).

    `extremes`, shape (n, 2), receives the least and the greatest torque of updates of the carrier, from the first
    control period of `_swing_rows` on.
    """
    run, length, count = record.run, record.scenario.control_period_s, _watched(record, window)
    rows = _swing_rows(record, window)
    first, drive = rows.start, record.plant_at(rows.start)
    delay = 1 if drive.modulator.update_delay > 0 else 0
    commands = run.commands[rows.start - delay : rows.stop - delay]
    ratios: NDArray[np.float64] = np.stack([commands[name] for name in DUTY_RATIOS], axis=1)
    legs: NDArray[np.int64] = np.stack([commands[name] for name in LEGS], axis=1)
    direct, quadrature = (float(run.column(name)[first - 1]) for name in ("direct", "quadrature"))
    # The commands fit the speed of their own time; another one would move the currents.
    speed = float(np.mean(run.column("speed")[rows]))
    return commanded_swing(
        drive,
        (direct, quadrature),
        float(run.column("angle")[first]),
        speed,
        run.column("link_mean")[rows],
        np.ascontiguousarray(ratios),
        np.ascontiguousarray(legs),
        first=first,
        ignored=len(ratios) - count,
        period=length,
        extremes=extremes,
    )


def _swing_rows(record: DutyRecord, window: DutyWindow) -> slice:
    """Return the control periods in which the swing of a window is followed, the first few of them unjudged."""
    end = round(window.end_s / record.scenario.control_period_s)
    first = end - _watched(record, window) - _LEAD
    # The plant begins with its lower switches on, which they are at the start of a carrier's period.
    return slice(first - first % 2, end)


def _extremes(record: DutyRecord, window: DutyWindow) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the judged updates' times (s), shape (n,), and their least and greatest torque (N·m), shape (n, 2)."""
    rows, every = _swing_rows(record, window), record.plant.modulator.control_every
    update = record.scenario.control_period_s / every
    extremes = np.zeros(((rows.stop - rows.start) * every, 2))
    _swing(record, window, extremes)
    begin = len(extremes) - _watched(record, window) * every
    return rows.start * every * update + np.arange(begin, len(extremes)) * update, extremes[begin:]


def _ideal_swing(record: DutyRecord, window: DutyWindow) -> float:
    """Return the swing of ideal modulation on the drive as it is at the end of a window (N·m)."""
    rows, length = _swing_rows(record, window), record.scenario.control_period_s
    drive = record.plant_at(rows.start)
    slowest = max(drive.direct_inductance, drive.quadrature_inductance)
    settled = _TIME_CONSTANTS * slowest / (drive.resistance * length) if drive.resistance > 0.0 else _LONGEST
    speed, watched = window.speed, max(_watched(record, window), LEAST_IDEAL_PERIODS)
    if not has_ideal_switches(drive):
        speed, watched = spread_samples(speed, _part(record) / (drive.pole_pairs * length), watched)
    return ideal_swing(
        drive,
        speed,
        exact_mean(record.run.column("link_mean")[rows]),
        (window.direct, window.quadrature),
        ignored=2 * ceil(min(settled, _LONGEST) / 2.0),
        watched=watched,
        period=length,
        kind=MODULATION_NUMBERS[record.declaration.modulation],
    )


def _is_rippling(record: DutyRecord, window: DutyWindow) -> bool:
    """Return True if a window has the speed, the torque and the voltage by which ripple is judged."""
    base = record.document.rating.base_speed_rpm * RADIANS_PER_RPM
    speed = record.run.column("speed")[record.periods(window.start_s, window.end_s)]
    if np.max(np.abs(speed - window.speed_reference)) > HELD_SHARE * base:
        return False
    is_slow = abs(window.speed) < LEAST_SPEED_SHARE * base
    is_weak = abs(window.torque) < LEAST_TORQUE_SHARE * record.document.rating.rated_torque_nm
    greatest = undistorted(record.plant, window.link)
    if is_slow or is_weak or window.voltage > VOLTAGE_SHARE * greatest:
        return False
    # Only of a shaft that turns. What the diodes alone make is no modulation.
    rows = _swing_rows(record, window)
    if chopper_burns(record, rows) or legs_are_off(record.run.commands[rows]).all():
        return False
    # Legs that ignore their duty ratios make another voltage than these ask for; the currents show the true one.
    warm = record.plant_at(rows.start)
    own = steady_state(warm, window.speed, window.direct, window.quadrature)
    return bool(own.voltage >= LEAST_VOLTAGE_SHARE * greatest)


def modulation_ripple(record: DutyRecord) -> Margin | None:
    return worst(margin for _, margin in _over_ideal(record))


def _over_ideal(record: DutyRecord) -> Iterator[tuple[DutyWindow, Margin]]:
    limit = record.limits.modulation_ripple
    for window in record.nominal:
        ideal = _ideal_swing(record, window) if _is_rippling(record, window) else inf
        if isfinite(ideal):
            margin = _over("RIP-4", record, window, ideal, limit, _ideal_words(record))
            if not margin.met and _looks_discontinuous(record, window):
                margin = replace(margin, measured=f"{margin.measured}; {_HINT}")
            yield window, margin


def _ideal_words(record: DutyRecord) -> str:
    kind = record.declaration.modulation
    return "of ideal modulation" if kind == NOTHING_DECLARED.modulation else f"of ideal {kind} modulation"


def _looks_discontinuous(record: DutyRecord, window: DutyWindow) -> bool:
    """Return True if nothing is declared, and nearly always a leg is clamped to a rail."""
    if record.declaration.modulation != NOTHING_DECLARED.modulation:
        return False
    commands = record.run.commands[record.periods(window.start_s, window.end_s)]
    ratios = np.stack([commands[name] for name in DUTY_RATIOS], axis=1)
    legs = np.stack([commands[name] for name in LEGS], axis=1)
    is_at_rail = (np.abs(ratios - 0.5) >= 0.5 - CLAMPED_RATIO) | (legs == LEG_LOW) | (legs == LEG_HIGH)
    return bool(np.mean(np.any(is_at_rail, axis=1)) >= CLAMPED_SHARE)


def modulation_moment(record: DutyRecord) -> Moment | None:
    """Show the torque at the end of the window that decides, next to the swing that is allowed."""
    least = decisive(_over_ideal(record))
    if least is None:
        return None
    window, _ = least
    allowed = _allowed(record, _ideal_swing(record, window), record.limits.modulation_ripple)
    return _moment([("torque", record, window)], allowed)


def dead_time_ripple(record: DutyRecord) -> Margin | None:
    """Judge the torque ripple at low speed with dead time by that of the same run without it."""
    return worst(margin for _, margin in _over_free(record))


def _over_free(record: DutyRecord) -> Iterator[tuple[_Pair, Margin]]:
    """Go through the windows of both runs that are compared, each pair with its margin."""
    other, limit = record.other_dead_time, record.limits.dead_time_ripple
    if other is None:
        return
    blanked, free = (record, other) if record.document.inverter.dead_time_s > 0.0 else (other, record)
    doing = f"with {_dead_time(blanked)} the torque"
    for window, plain in zip(blanked.steady, free.steady, strict=False):
        if free.is_nominal and _is_rippling(free, plain):
            words = "without dead time"
            margin = _over("DTM-1", blanked, window, _swing(free, plain), limit, words, doing)
            yield ((blanked, window), (free, plain)), margin


def _dead_time(blanked: DutyRecord) -> str:
    return f"{1e6 * blanked.document.inverter.dead_time_s:.4g} µs of dead time"


def dead_time_moment(record: DutyRecord) -> Moment | None:
    """Show the torque of both runs at the end of the window that decides, next to the swing that is allowed."""
    least = decisive(_over_free(record))
    if least is None:
        return None
    (blanked, free), _ = least
    allowed = _allowed(blanked[0], _swing(*free), record.limits.dead_time_ripple)
    return _moment([(_dead_time(blanked[0]), *blanked), ("no dead time", *free)], allowed)


def _moment(runs: Sequence[tuple[str, DutyRecord, DutyWindow]], allowed: float) -> Moment:
    """Show the extremes of the torque in the part of a cycle in which its swing is measured, of one run or of two."""
    courses: list[Course] = []
    found = [(words, *_extremes(record, window)) for words, record, window in runs]
    for words, times, extremes in found:
        courses.append(course_of(f"{words}: greatest", times, extremes[:, 1]))
        courses.append(course_of(f"{words}: least", times, extremes[:, 0]))
    _, times, extremes = found[0]
    least, place = float(np.min(extremes[:, 0])), int(np.argmax(extremes[:, 1]))
    greatest, step = float(extremes[place, 1]), float(times[1] - times[0])
    return Moment(
        start_s=min(float(times[0]) for _, times, _ in found),
        end_s=max(float(times[-1]) for _, times, _ in found) + step,
        quantity="torque (N·m)",
        courses=tuple(courses),
        levels=(
            Mark(words="least", value=least),
            Mark(words=f"limit: swing {allowed:.4g} N·m", value=least + allowed),
        ),
        point=Point(words=f"swing {greatest - least:.4g} N·m", time_s=float(times[place]), value=greatest),
    )


def _over(
    check: str,
    record: DutyRecord,
    window: DutyWindow,
    other: float,
    limit: float,
    words: str,
    doing: str = "torque",
) -> Margin:
    """Judge the swing of a window by another swing, and by what is always allowed."""
    swing = _swing(record, window)
    times = f"{swing / other:.4g} times " if other > 0.0 else ""
    finding = f"{doing} swings by {swing:.4g} N·m, {times}the {other:.4g} N·m {words}, {at(window)}"
    return Margin(check, at_most(swing, _allowed(record, other, limit)), finding)


def _allowed(record: DutyRecord, other: float, limit: float) -> float:
    """Return the greatest swing that is allowed (N·m), by another swing (N·m) and its multiple."""
    return max(limit * other, LEAST_SWING_SHARE * record.document.rating.rated_torque_nm)


RIP_4 = Check(
    id="RIP-4",
    families=("torque step", "speed step", "load step", "start", "restart"),
    requirement=(
        "In steady state the torque ripple is at most {modulation_ripple} times that of ideal modulation, or "
        "0.5 % of rated torque."
    ),
    limit="{modulation_ripple} times the ripple of ideal modulation of the declared kind at the same currents and "
    "speed on the same drive, but at least 0.5 % of rated torque",
    scenarios="steady stretches of the nominal drive from 10 % of rated torque and 5 % of base speed on, that take 1 "
    "to 95 % of the voltage and no pulse that is nearly too short for the modulator, with the bridge on and the "
    "chopper off, while the speed stays within 5 % of base speed of its reference",
    formula="1 - torque's swing over a sixth of a cycle / the limit",
    why="What the torque swings by beyond what switching takes is noise and wear for nothing.",
    evaluate=modulation_ripple,
    moment=modulation_moment,
)
DTM_1 = Check(
    id="DTM-1",
    families=("torque step",),
    requirement=(
        "At 5 to 10 % of base speed the torque ripple with dead time is at most {dead_time_ripple} times that "
        "without, or 0.5 % of rated torque."
    ),
    level="advisory",
    limit="{dead_time_ripple} times the ripple without dead time, but at least 0.5 % of rated torque",
    scenarios="steady torques at 5 to 10 % of base speed, run with dead time and without",
    formula="1 - torque's swing with dead time / the limit",
    why="Dead time takes voltage by the sign of each current, and most of it where there is little.",
    evaluate=dead_time_ripple,
    moment=dead_time_moment,
)
