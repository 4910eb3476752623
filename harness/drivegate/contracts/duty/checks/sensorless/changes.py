"""Checks of a load that steps and of a reversal without a position sensor."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, Mark, Moment, Point, at_most
from drivegate.checks.stretches import stretches
from drivegate.contracts.duty.checks.judged import decisive, worst
from drivegate.contracts.duty.checks.sensorless.judged import (
    if_speed,
    least_speed,
    regulates_speed,
)
from drivegate.contracts.duty.checks.sensorless.measures import back_after_s, longest_s, time_below_s
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.scenarios.reaching import load_on_shaft
from drivegate.contracts.duty.scenarios.sensorless import BACK_S, LOADED_SHARE
from drivegate.contracts.duty.scenarios.unsensed import REACTION_S
from drivegate.contracts.duty.scenarios.windows import duty_dwells
from drivegate_cases.scenario.profile import Dwell
from drivegate_models.units import RADIANS_PER_RPM

LEAST_DIP_SHARE = 0.05
"""Speed that a load may always move the shaft by, over base speed (1)."""
HALF = 0.5
"""Share of the reference that the speed may be off by for a short time (1)."""
OUT_OF_STEP_S = 0.2
"""That time (s)."""
SLOWER, ADDED_S = 2.0, 0.5
"""Time below the least speed in a reversal: over that of the reference (1), and added (s)."""


def load_step(record: DutyRecord) -> Margin | None:
    """Judge the steps of a load at a steady speed."""
    if not regulates_speed(record) or not record.is_nominal:
        return None
    return worst(
        margin for before, dwell in _load_steps(record) for margin in _step_margins(record, before, dwell)
    )


def _load_steps(record: DutyRecord) -> list[tuple[Dwell, Dwell]]:
    """List the stretches before and after each change that is judged."""
    settled = {window[0].start for window in record.windows}
    return [
        (before, dwell)
        for before, dwell in pairwise(duty_dwells(record.scenario))
        if before.end == dwell.start and before.start in settled and dwell.duration > BACK_S
    ]


def load_step_moment(record: DutyRecord) -> Moment | None:
    """Show the speed after the step of the load that decides."""
    least = decisive(
        (dwell, margin)
        for before, dwell in _load_steps(record)
        for margin in _step_margins(record, before, dwell)
    )
    if load_step(record) is None or least is None:
        return None
    dwell, margin = least
    period, reference = record.scenario.control_period_s, dwell.speed_rpm * RADIANS_PER_RPM
    rows = record.periods(dwell.start, dwell.end)
    error = record.run.column("speed")[rows] - reference
    band = LEAST_DIP_SHARE * record.document.rating.base_speed_rpm
    if "back" in margin.measured:
        place = round(min(back_after_s(error, band * RADIANS_PER_RPM, period), dwell.duration) / period) - 1
    elif "half" in margin.measured:
        is_off = np.abs(error) > HALF * abs(reference)
        place = max(stretches(is_off), key=lambda stretch: stretch[1] - stretch[0])[1] - 1
    else:
        place = int(np.argmax(np.abs(error)))
    place = min(max(place, 0), len(error) - 1)
    time = (rows.start + place + 0.5) * period
    levels = ((f"reference {dwell.speed_rpm:.4g} rpm", 0.0), ("± 5 % of base speed", band), ("", -band))
    return Moment(
        start_s=dwell.start,
        end_s=min(max(2.0 * (time - dwell.start), OUT_OF_STEP_S) + dwell.start, dwell.end),
        column="speed_rpm",
        origin_s=dwell.start,
        levels=tuple(
            Mark(words=words or "± 5 % of base speed", value=dwell.speed_rpm + value)
            for words, value in levels
        ),
        point=Point(
            words=margin.measured.partition(" after the load")[0],
            time_s=time,
            value=float(error[place] / RADIANS_PER_RPM + dwell.speed_rpm),
        ),
    )


def _step_margins(record: DutyRecord, before: Dwell, dwell: Dwell) -> list[Margin]:
    reference = dwell.speed_rpm * RADIANS_PER_RPM
    loads = [load_on_shaft(record.scenario, each, reference) for each in (before, dwell)]
    if before.speed_rpm != dwell.speed_rpm or loads[0] == loads[1]:
        return []
    rating, machine, period = (
        record.document.rating,
        record.document.machine,
        record.scenario.control_period_s,
    )
    speed = record.run.column("speed")[record.periods(dwell.start, dwell.end)]
    error = speed - reference
    floor = LEAST_DIP_SHARE * rating.base_speed_rpm * RADIANS_PER_RPM
    allowed = max(LOADED_SHARE * rating.rated_torque_nm * REACTION_S / machine.inertia_kg_m2, floor)
    dip = float(np.max(np.abs(error)))
    back = min(back_after_s(error, floor, period), dwell.duration)
    out = longest_s(np.abs(error) > HALF * abs(reference), period)
    after = f"after the load step at {dwell.start:.4g} s"
    return [
        Margin("SLS-4", at_most(dip, allowed), f"{dip / RADIANS_PER_RPM:.4g} rpm off {after}"),
        Margin("SLS-4", at_most(back, BACK_S), f"speed back {back:.3g} s {after}"),
        Margin(
            "SLS-4",
            at_most(out, OUT_OF_STEP_S),
            f"speed off by half of its reference for {out:.3g} s {after}",
        ),
    ]


def reversal(record: DutyRecord) -> Margin | None:
    """Judge the time for which a reversal is slower than the least speed."""
    if not regulates_speed(record) or not record.is_nominal or (ramp := _reversal(record)) is None:
        return None
    begin, end = ramp
    period, least = record.scenario.control_period_s, least_speed(record)
    first = round(begin / period)
    wanted, speed = (record.run.column(name)[first:] for name in ("speed_reference", "speed"))
    allowed = SLOWER * time_below_s(wanted, least, period) + ADDED_S
    found = time_below_s(speed, least, period)
    measured = (
        f"{found:.4g} s below the least speed, {allowed:.4g} s are allowed, in the reversal at {begin:.4g} s"
    )
    last = float(speed[-1] * wanted[-1])
    turned = Margin("SLS-5", 1.0 if last > 0.0 else -1.0, f"the shaft turns the wrong way after {end:.4g} s")
    return worst((Margin("SLS-5", at_most(found, allowed), measured), turned))


def reversal_moment(record: DutyRecord) -> Moment | None:
    """Show the speed from where it falls below the least one in a reversal until it is above for good."""
    margin, ramp = reversal(record), _reversal(record)
    if margin is None or ramp is None:
        return None
    period, least = record.scenario.control_period_s, least_speed(record)
    speed = record.run.column("speed")
    below = round(ramp[0] / period) + np.flatnonzero(np.abs(speed[round(ramp[0] / period) :]) < least)
    first, last = (int(below[0]), int(below[-1])) if below.size else (len(speed) - 2, len(speed) - 1)
    if "wrong way" in margin.measured:
        last = len(speed) - 1
    shown = 0.25 * (last - first + 1) * period
    rpm = record.document.least_speed_rpm
    return Moment(
        start_s=max(first * period - shown, 0.0),
        end_s=min((last + 1) * period + shown, record.scenario.duration_s),
        column="speed_rpm",
        origin_s=first * period,
        levels=tuple(Mark(words=f"± {rpm:.4g} rpm", value=value) for value in (rpm, -rpm)),
        point=Point(
            words=margin.measured.partition(",")[0],
            time_s=(last + 0.5) * period,
            value=float(speed[last] / RADIANS_PER_RPM),
        ),
    )


def _reversal(record: DutyRecord) -> tuple[float, float] | None:
    """Return start and end of the ramp of the reference from one sense to the other (s); None without any."""
    for (begin, before), (end, after) in pairwise(record.scenario.speed_rpm):
        if before * after < 0.0 and end > begin and begin > 0.0:
            return begin, end
    return None


SLS_4 = Check(
    id="SLS-4",
    families=("sensorless load step",),
    requirement=(
        "Without a position sensor, from twice the least speed on, a load of 80 % of rated torque that comes on or "
        "goes moves the speed by at most what 80 % of rated torque does in 50 ms, or 5 % of base speed. After 2 s the "
        "speed is within 5 % of base speed, and it is off by half of its reference for at most 200 ms."
    ),
    limit="80 % of rated torque for 50 ms on the inertia, at least 5 % of base speed; back within 2 s",
    scenarios="steps of the load at a steady speed of the nominal drive",
    formula="the least of 1 - speed change / limit, 1 - time until the speed is back / 2 s, and 1 - time off by half / "
    "200 ms",
    why="An observer loses the rotor when the torque changes faster than it follows.",
    evaluate=load_step,
    moment=load_step_moment,
    reason_not_applicable=if_speed,
)
SLS_5 = Check(
    id="SLS-5",
    families=("sensorless reversal",),
    requirement=(
        "Without a position sensor, a ramp of the reference through zero reverses the shaft under up to half of rated "
        "torque. The shaft is below the least speed for at most twice as long as the reference, and 0.5 s."
    ),
    limit="twice the reference's time below the least speed, and 0.5 s",
    scenarios="reversals of the nominal drive by a ramp that changes the reference by base speed in 1 s",
    formula="1 - time below the least speed / limit; -1 where the shaft turns the wrong way at the end",
    why="No observer of the EMF sees a rotor at standstill; a sign that holds one way only shows here.",
    evaluate=reversal,
    moment=reversal_moment,
    reason_not_applicable=lambda declaration, drive: (
        if_speed(declaration, drive) or (None if declaration.reverses else "the candidate does not reverse")
    ),
)
