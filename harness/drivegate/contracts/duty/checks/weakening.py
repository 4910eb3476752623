"""Checks of flux weakening: enough of it, none where it is not needed, and a safe way out of it."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite
from typing import Final

import numpy as np

from drivegate.candidates.declaration import Declaration
from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, Mark, Moment, Point, at_most, normalised
from drivegate.contracts.duty.checks.current import FREE_SHARE
from drivegate.contracts.duty.checks.judged import (
    SHOWN_BEFORE,
    STEADY_FAMILIES,
    TURNED_SHARE,
    Purpose,
    at,
    greatest_at,
    greatest_required,
    if_unsensed,
    is_within_reach,
    least_free,
    undistorted,
    worst,
)
from drivegate.contracts.duty.checks.steps import TorqueStep, overshoot_of, torque_steps
from drivegate.contracts.duty.current_reference import unless_current
from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.record import DutyRecord, DutyWindow
from drivegate.scenarios.rotation import sense_of
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_models.units import RADIANS_PER_RPM

SHOWN_AFTER: Final = 100
"""Control periods after a release that figures show at least."""
_PURPOSES: Final[tuple[Purpose, ...]] = ("current", "loss")


def _unless_weakened(declaration: Declaration, drive: DriveDocument) -> str | None:
    if duty_document(drive).weakens:
        return unless_current(declaration, drive)
    return (
        "the drive is stated without field weakening: its highest speed is its base speed of "
        f"{drive.rating.base_speed_rpm:g} rpm"
    )


def weakened_torque(record: DutyRecord) -> Margin | None:
    return worst(_share_of_greatest(record, window) for window in _weakened(record))


def _weakened(record: DutyRecord) -> Iterator[DutyWindow]:
    base = record.document.rating.base_speed_rpm * RADIANS_PER_RPM
    for window in record.nominal:
        wanted = window.torque_reference
        if (
            wanted is not None
            and sense_of(window.speed) * wanted > 0.0
            and abs(window.speed) > base
            and not is_within_reach(record, window.speed, window.link, wanted)
        ):
            yield window


def _share_of_greatest(record: DutyRecord, window: DutyWindow) -> Margin:
    greatest = greatest_required(record, window.speed, window.link)
    if not isfinite(greatest) or greatest <= 0.0:
        # Nothing can be asked of a speed at which the limits leave no torque.
        return Margin("FWK-1", 1.0, f"no torque is possible {at(window)}")
    sense = sense_of(window.speed)
    wanted = min(sense * (window.torque_reference or 0.0), greatest)
    least = record.limits.weakening * wanted
    voltage = f"with {100.0 * record.limits.weakening_voltage:g} % of the voltage"
    measured = f"{window.torque:.4g} of {sense * wanted:.4g} N·m possible {voltage} {at(window)}"
    return Margin("FWK-1", normalised(sense * window.torque - least, least), measured)


def needless_direct_current(record: DutyRecord) -> Margin | None:
    free: list[DutyWindow] = []
    used: list[DutyWindow] = []
    for window in record.nominal:
        is_free = window.voltage < FREE_SHARE * undistorted(record.plant, window.link)
        (free if is_free else used).append(window)
    if used and not free:
        # Met, not unjudged: a controller that weakens less is a witness against one that weakens too much.
        return Margin("FWK-2", 1.0, f"less than 10 % of the voltage is free {at(used[0])}")
    return worst(_direct_error(record, window) for window in free)


def _direct_error(record: DutyRecord, window: DutyWindow) -> Margin | None:
    # Weakening may keep this much voltage in reserve, and only what goes further is needless. None is needed where the
    # voltage suffices, which the controller may know better: dead time takes some of it when motoring, and gives it
    # back when braking.
    plant, voltage = record.plant, FREE_SHARE * undistorted(record.plant, window.link)
    best, cool = (
        least_free(plant, window.speed, window.torque, voltage, purpose).direct for purpose in _PURPOSES
    )
    unweakened = least_free(plant, window.speed, window.torque).direct
    if not (isfinite(best) and isfinite(cool) and isfinite(unweakened)):
        return None
    right = (best, cool, unweakened)
    error = max(min(right) - window.direct, window.direct - max(right), 0.0)
    measured = (
        f"d current {window.direct:.4g} A, {best:.4g} A is best for {window.torque:.4g} N·m {at(window)}"
    )
    # The current turns with an angle that is off.
    allowed = record.limits.direct_error_a + if_unsensed(record, TURNED_SHARE) * abs(window.quadrature)
    return Margin("FWK-2", at_most(error, allowed), measured)


def way_out_of_weakening(record: DutyRecord) -> Margin | None:
    return worst(_release(record, step) for step in torque_steps(record) if _is_release(record, step))


def release_moment(record: DutyRecord) -> Moment | None:
    """Show the torque or the current after the release that decides."""
    releases = (step for step in torque_steps(record) if _is_release(record, step))
    step = min(releases, key=lambda step: _release(record, step).value, default=None)
    if step is None:
        return None
    period, limits, rows = record.scenario.control_period_s, record.limits, step.rows
    torque, current = (record.run.column(name)[rows] for name in ("torque", "peak_current"))
    size = sense_of(step.speed_rpm) * _step_size(record, step)
    if at_most(overshoot_of(torque, step.after, -size), limits.braking) <= at_most(
        float(np.max(current)), limits.peak_a
    ):
        values, column, unit = torque, "torque_nm", "N·m"
        place, allowed = int(np.argmin(torque / size)), step.after - limits.braking * size
    else:
        values, column, unit = current, "peak_current_a", "A"
        place, allowed = int(np.argmax(current)), limits.peak_a
    end = rows.start + max(2 * place, SHOWN_AFTER)
    return Moment(
        start_s=max(rows.start - SHOWN_BEFORE, 0) * period,
        end_s=min(end, rows.stop) * period,
        column=column,
        origin_s=step.time_s,
        levels=(Mark(words=f"limit {allowed:.4g} {unit}", value=allowed),),
        point=Point(
            words=f"{values[place]:.4g} {unit}",
            time_s=(rows.start + place + 0.5) * period,
            value=float(values[place]),
        ),
    )


def _is_release(record: DutyRecord, step: TorqueStep) -> bool:
    is_driven = sense_of(step.speed_rpm) * step.before > 0.0 == step.after
    return is_driven and abs(step.speed_rpm) > record.document.rating.base_speed_rpm


def _step_size(record: DutyRecord, step: TorqueStep) -> float:
    """Return the torque by which a release is measured: what was possible before it, at least rated torque (N·m)."""
    link = float(record.run.column("link")[step.rows.start])
    greatest = greatest_at(record.plant, abs(step.speed_rpm) * RADIANS_PER_RPM, link).torque
    required = abs(step.before)
    before = min(required, greatest) if isfinite(greatest) else required
    return max(before, record.document.rating.rated_torque_nm)


def _release(record: DutyRecord, step: TorqueStep) -> Margin:
    torque = record.run.column("torque")[step.rows]
    peak = float(np.max(record.run.column("peak_current")[step.rows]))
    size = _step_size(record, step)
    braking = overshoot_of(torque, step.after, -sense_of(step.speed_rpm) * size)
    limits = record.limits
    place = f"after {step.time_s:.4g} s at {step.speed_rpm:.5g} rpm"
    measured = f"braking with {braking * size:.4g} N·m, {100.0 * braking:.3g} % of {size:.4g} N·m, {place}"
    return min(
        Margin("FWK-3", at_most(braking, limits.braking), measured),
        Margin("FWK-3", at_most(peak, limits.peak_a), f"{peak:.4g} A {place}"),
        key=lambda margin: margin.value,
    )


FWK_1 = Check(
    id="FWK-1",
    families=("weakening",),
    requirement=(
        "Above base speed the mean torque is at least {weakening} of the greatest that the current limit and "
        "{weakening_voltage} of the voltage allow."
    ),
    limit="at least {weakening} of the greatest torque with {weakening_voltage} of the voltage",
    scenarios="steady stretches above {base} on the nominal drive that ask for more than {weakening} of that torque",
    formula=(
        "mean torque / ({weakening} of the oracle's greatest torque with {weakening_voltage} of the voltage, or of the "
        "reference where that is less) - 1"
    ),
    why="Without weakening there is no torque where the back-EMF uses up the link.",
    evaluate=weakened_torque,
    reason_not_applicable=_unless_weakened,
)
FWK_2 = Check(
    id="FWK-2",
    families=STEADY_FAMILIES,
    requirement=(
        "Where 10 % of the voltage is free the d current is within {direct_error} of that of least current, "
        "of least loss, or between them."
    ),
    limit="± {direct_error}",
    scenarios="steady stretches of the nominal drive; those that use over 90 % of the undistorted voltage meet it",
    formula="1 - distance of the d current from the oracle's / {direct_error}",
    why="Weakening that stays on heats the winding, also at standstill.",
    evaluate=needless_direct_current,
    reason_not_applicable=unless_current,
)
FWK_3 = Check(
    id="FWK-3",
    families=("torque step", "weakening"),
    requirement=(
        "After a torque reference goes to zero above base speed, the drive brakes with at most {braking} of "
        "the step or of rated torque, and no phase current exceeds {peak}."
    ),
    limit="braking {braking} of the step or of rated torque, whichever is more; current {peak}",
    scenarios="steps of the torque reference to zero above {base}",
    formula="the lesser of 1 - braking torque / {braking} of that torque and 1 - greatest phase current / {peak}",
    why="Weakening that is dropped at once lets the back-EMF drive the current into the link.",
    evaluate=way_out_of_weakening,
    moment=release_moment,
    reason_not_applicable=_unless_weakened,
)
