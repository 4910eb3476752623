"""Checks of windings that get hot: their limit, what is derated, and how."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite, sqrt
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.declaration import Declaration
from drivegate.checks.check import Check
from drivegate.checks.course import course_of
from drivegate.checks.margin import Margin, Mark, Moment, Point, at_most, normalised
from drivegate.checks.means import exact_mean
from drivegate.contracts.duty.checks.judged import at, greatest_at, worst
from drivegate.contracts.duty.current_reference import unless_current
from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.record import DutyRecord, DutyWindow
from drivegate.contracts.duty.scenarios.hot import (
    APPROACH,
    COOL_SHARE,
    HOT_SHARE,
    SETTLED_S,
    HotWindings,
    sensed_windings,
)
from drivegate.contracts.duty.scenarios.windows import duty_dwells
from drivegate.scenarios.rotation import sense_of
from drivegate_cases.drive.drive_document import DriveDocument

HOT_FAMILY: Final = "hot winding"
"""The family of runs whose windings are warm or hot at first."""
WARM_ERROR: Final = 2.0
"""Error of the torque of warm windings over that of cool ones, as their resistance is not the nominal one (1)."""
_SHOWN_MEANS: Final = 20
"""Means that figures show before and after a change."""
STRETCH_S: Final = 0.01
"""Length of the means whose changes are judged (s)."""
SHOWN_S: Final = 1.0
"""Time that figures show before the hottest moment (s)."""
AFTER_STEP_S: Final = 0.1
"""Time from a change of the reference on in which the torque may change at any rate (s)."""


def _unless_sensed(declaration: Declaration, drive: DriveDocument) -> str | None:
    if sensed_windings(duty_document(drive)) is not None:
        return unless_current(declaration, drive)
    return "the drive states no [thermal] with a sensor_lag_s, so that controllers see no temperature of its windings"


def _windings(record: DutyRecord) -> HotWindings | None:
    return None if record.fails else sensed_windings(record.document)


def _shares(record: DutyRecord, windings: HotWindings) -> NDArray[np.float64]:
    """Return the rise of the temperature over the permitted one at the start of each control period, shape (n,)."""
    shares: NDArray[np.float64] = (
        record.run.column("winding_temperature") - windings.thermal.ambient_c
    ) / windings.thermal.rise_k
    return shares


def temperature_limit(record: DutyRecord) -> Margin | None:
    windings = _windings(record)
    if windings is None:
        return None
    shares = _shares(record, windings)
    place = int(np.argmax(shares))
    hottest = windings.thermal.ambient_c + float(shares[place]) * windings.thermal.rise_k
    found = f"windings at {hottest:.4g} °C at {place * record.scenario.control_period_s:.4g} s"
    return Margin("THM-1", at_most(float(shares[place]), record.limits.temperature_rise), found)


def temperature_moment(record: DutyRecord) -> Moment | None:
    """Show the temperature until it is the highest."""
    windings, period = _windings(record), record.scenario.control_period_s
    if windings is None:
        return None
    temperatures = record.run.column("winding_temperature")
    place, thermal = int(np.argmax(temperatures)), windings.thermal
    time, hottest = (place + 0.5) * period, float(temperatures[place])
    allowed = thermal.ambient_c + record.limits.temperature_rise * thermal.rise_k
    return Moment(
        start_s=max(time - SHOWN_S, 0.0),
        end_s=min(time + 0.2 * SHOWN_S, record.scenario.duration_s),
        column="winding_temperature_c",
        quantity="windings (°C)",
        levels=(Mark(words=f"limit {allowed:.4g} °C", value=allowed),),
        point=Point(words=f"{hottest:.4g} °C", time_s=time, value=hottest),
    )


def whole_current(record: DutyRecord) -> Margin | None:
    windings = _windings(record)
    if windings is None:
        return None
    shares = _shares(record, windings)
    hot = (
        window
        for window in record.steady
        if shares[record.periods(window.start_s, window.end_s)].min() >= HOT_SHARE
    )
    return worst(_current(record, window, windings) for window in hot)


def _current(record: DutyRecord, window: DutyWindow, windings: HotWindings) -> Margin:
    rows = record.periods(window.start_s, window.end_s)
    direct, quadrature = (record.run.column(name)[rows] for name in ("direct", "quadrature"))
    current = sqrt(exact_mean(direct * direct + quadrature * quadrature))
    found = (
        f"{current:.4g} A, of which d current {window.direct:.4g} A, where hot windings bear {windings.current:.4g} A "
        f"{at(window)}"
    )
    return Margin("THM-2", at_most(current, record.limits.derated_current * windings.current), found)


def derating(record: DutyRecord) -> Margin | None:
    windings = _windings(record)
    if windings is None or record.scenario.winding_temperature_c is None:
        return None
    shares = _shares(record, windings)
    return worst((*_of_means(record, windings, shares), *(step.margin for step in _steps(record))))


def _of_means(
    record: DutyRecord, windings: HotWindings, shares: NDArray[np.float64]
) -> Iterator[Margin | None]:
    for window in record.steady:
        yield _cool_torque(record, window, windings, shares)
        yield _hot_torque(record, window, windings)


def derating_moment(record: DutyRecord) -> Moment | None:
    """Show the means of the torque around the change that decides; None where a mean itself decides."""
    margin, step = (
        derating(record),
        min(_steps(record), key=lambda each: each.margin.value, default=None),
    )
    if margin is None or step is None or step.margin.value > margin.value:
        return None
    before, after = step.means[step.place : step.place + 2]
    first = max(step.place - _SHOWN_MEANS, 0)
    shown = step.means[first : step.place + _SHOWN_MEANS]
    # Each mean is drawn at the middle of its stretch.
    times = step.start + (np.arange(len(shown)) + first + 0.5) * STRETCH_S
    return Moment(
        start_s=float(times[0]),
        end_s=float(times[-1]),
        quantity="torque over 10 ms (N·m)",
        courses=(course_of("mean", times, shown),),
        levels=(Mark(words=f"{before:.4g} N·m before", value=float(before)),),
        point=Point(
            words=f"{after:.4g} N·m after",
            time_s=step.start + (step.place + 1.5) * STRETCH_S,
            value=float(after),
        ),
    )


def _greatest(record: DutyRecord, window: DutyWindow, windings: HotWindings, current: float) -> float:
    """Return the greatest driving torque within a current (A) with hot windings (N·m); NaN where there is none."""
    plant = windings.plant._replace(current_limit=current)
    link = record.limits.weakening_voltage * window.link
    return greatest_at(plant, abs(window.speed), link, weakens=record.document.weakens).torque


def _cool_torque(
    record: DutyRecord, window: DutyWindow, windings: HotWindings, shares: NDArray[np.float64]
) -> Margin | None:
    """Judge the torque of windings that are not near their limit: it is the whole reference."""
    wanted = window.torque_reference
    if wanted is None or shares[: round(window.end_s / record.scenario.control_period_s)].max() > COOL_SHARE:
        return None
    greatest = _greatest(record, window, windings, record.document.rating.current_limit_a)
    if not abs(wanted) <= record.limits.weakening * greatest:
        return None
    error = abs(window.torque - wanted)
    found = f"torque {window.torque:.4g} of {wanted:.4g} N·m with cool windings {at(window)}"
    return Margin("THM-3", at_most(error, WARM_ERROR * record.limits.torque_error_nm), found)


def _hot_torque(record: DutyRecord, window: DutyWindow, windings: HotWindings) -> Margin | None:
    """Judge the torque of windings that have come to their limit: a part of what they bear for good."""
    wanted, sense = window.torque_reference, sense_of(window.speed)
    if wanted is None or sense * wanted <= 0.0:
        return None
    begun = record.run.column("winding_temperature")[
        round(window.dwell.start / record.scenario.control_period_s)
    ]
    heating = max(windings.thermal.limit_c - float(begun), 0.0) / windings.rate
    left = (1.0 - COOL_SHARE) * windings.thermal.rise_k / windings.rate
    if begun >= windings.temperature_c(HOT_SHARE) or window.dwell.duration < APPROACH * heating + SETTLED_S:
        return None
    if heating > left:
        return None
    greatest = _greatest(record, window, windings, windings.plant.current_limit)
    if not isfinite(greatest) or greatest <= 0.0:
        return None
    least = record.limits.derated_torque * min(sense * wanted, greatest)
    found = f"torque {window.torque:.4g} N·m, where hot windings bear {greatest:.4g} N·m {at(window)}"
    return Margin("THM-3", normalised(sense * window.torque - least, least), found)


class _Step(NamedTuple):
    """The greatest change of the torque under one reference."""

    margin: Margin
    start: float
    """Time at which the first mean begins (s)."""
    means: NDArray[np.float64]
    """Means of the torque one after the other (N·m), shape (n,)."""
    place: int
    """Which mean is the last one before the change."""


def _steps(record: DutyRecord) -> Iterator[_Step]:
    """Judge the changes of the torque under a constant reference, from one mean to the next."""
    torque, period = record.run.column("torque"), record.scenario.control_period_s
    count, allowed = max(round(STRETCH_S / period), 1), record.limits.derating_step_nm
    for dwell in duty_dwells(record.scenario):
        rows = record.periods(dwell.start + AFTER_STEP_S, dwell.end)
        means = torque[rows][: (rows.stop - rows.start) // count * count].reshape(-1, count).mean(axis=1)
        if dwell.torque_reference_nm is None or len(means) < 2:
            continue
        steps = np.abs(np.diff(means))
        place = int(np.argmax(steps))
        time = dwell.start + AFTER_STEP_S + (place + 1) * STRETCH_S
        found = f"torque from {means[place]:.4g} to {means[place + 1]:.4g} N·m at {time:.4g} s, by no new reference"
        margin = Margin("THM-3", at_most(float(steps[place]), allowed), found)
        yield _Step(margin, dwell.start + AFTER_STEP_S, means, place)


THM_1 = Check(
    id="THM-1",
    families=(HOT_FAMILY,),
    requirement="The temperature of the windings rises above its surroundings by at most {temperature_rise} of the "
    "permitted rise.",
    limit="{temperature_rise} of the permitted rise",
    scenarios="every run of a drive with a sensor in its windings, also begun at their limit under the peak torque",
    formula="1 - (rise above the surroundings / permitted rise) / {temperature_rise}",
    why="Insulation that gets too hot ages in hours, and magnets lose their flux.",
    evaluate=temperature_limit,
    moment=temperature_moment,
    reason_not_applicable=_unless_sensed,
)
THM_2 = Check(
    id="THM-2",
    families=(HOT_FAMILY,),
    requirement="At the limit of the temperature the whole current, d and q, is at most {derated_current} of what the "
    "windings bear for good.",
    limit="{derated_current} of the continuous current",
    scenarios="steady torques, also in weakening, with windings from 98 % of the permitted rise on",
    formula="1 - rms of (d current, q current) / {derated_current} of the continuous current",
    why="A limit of the q current alone leaves the current of weakening, which heats as much.",
    evaluate=whole_current,
    reason_not_applicable=_unless_sensed,
)
THM_3 = Check(
    id="THM-3",
    families=(HOT_FAMILY,),
    requirement="Up to 90 % of the permitted rise the torque is the whole reference; at the limit it is at least "
    "{derated_torque} of what the windings bear for good; and under a constant reference it changes by at most "
    "{derating_step} from one mean over 10 ms to the next.",
    limit="2 × {torque_error}, {derated_torque}, and {derating_step}",
    scenarios="torques with warm, hot and heated windings",
    formula="the least of 1 - |mean - reference| / (2 × {torque_error}), mean / least torque - 1, and 1 - change / "
    "{derating_step}",
    why="Torque that is taken too early, or in jumps, is what riders and machines notice of derating.",
    evaluate=derating,
    moment=derating_moment,
    reason_not_applicable=_unless_sensed,
)
