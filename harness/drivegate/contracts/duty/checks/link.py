"""Checks of a dc link with a capacitor: its voltage, its source's current, and the braking that they leave."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.declaration import Declaration
from drivegate.checks.check import Check
from drivegate.checks.course import course_of
from drivegate.checks.margin import Margin, Mark, Moment, Point, at_most, normalised
from drivegate.contracts.duty.checks.judged import at, chopper_burns, decisive, worst
from drivegate.contracts.duty.current_reference import unless_current
from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.record import DutyRecord, DutyWindow
from drivegate.contracts.duty.scenarios.reaching import greatest_braking
from drivegate.scenarios.rotation import sense_of
from drivegate_cases.drive.drive_document import DriveDocument

LINK_FAMILIES: Final = ("link", "torque step", "speed step", "weakening")
"""Families of runs that charge and discharge a link."""
MEAN_S: Final = 0.01
"""Time over which the current of the source is averaged (s)."""
AFTER_SUPPLY_STEP: Final = 10.0
"""Time in which a step of the source charges the link, in its time constants with the source (1)."""
LEAST_BRAKING: Final = 0.05
"""Least of the oracle's greatest braking torque that is judged, over rated torque (1)."""
SHOWN_S: Final = 0.05
"""Time that figures show before and after what decides (s)."""


def _unless_linked(declaration: Declaration, drive: DriveDocument) -> str | None:
    if duty_document(drive).real_link is None:
        return "the drive's link is ideal: it states no [link] with a capacitor"
    return unless_current(declaration, drive)


def _is_judged(record: DutyRecord) -> bool:
    """Return True for a run on the nominal drive; after a restart no controller knows the power that flows."""
    return record.is_nominal and record.document.real_link is not None and not record.scenario.restarts_s


def link_limit(record: DutyRecord) -> Margin | None:
    if not _is_judged(record):
        return None
    highest, limit = record.run.column("link_highest"), record.plant.dc_link.limit
    place = _highest_place(record)
    found = f"link at {highest[place]:.4g} V at {place * record.scenario.control_period_s:.4g} s"
    return Margin("LNK-1", at_most(float(highest[place]), limit), found)


def link_moment(record: DutyRecord) -> Moment:
    """Show the link around its greatest voltage."""
    place, limit = _highest_place(record), record.plant.dc_link.limit
    start, end, time = shown_around(record, place)
    volts = float(record.run.column("link_highest")[place])
    return Moment(
        start_s=start,
        end_s=end,
        column="link_highest_v",
        quantity="highest link voltage (V)",
        levels=(Mark(words=f"limit {limit:.4g} V", value=limit),),
        point=Point(words=f"{volts:.4g} V", time_s=time, value=volts),
    )


def _highest_place(record: DutyRecord) -> int:
    """Return the control period of the greatest voltage that is judged."""
    highest = record.run.column("link_highest")
    # What the diodes alone have charged before the first answer acts, nobody prevents.
    begin = int(np.argmax(highest <= record.plant.dc_link.limit))
    return begin + int(np.argmax(highest[begin:]))


def shown_around(record: DutyRecord, place: int) -> tuple[float, float, float]:
    """Return start and end of the stretch that figures show around a control period, and its middle (s)."""
    time = (place + 0.5) * record.scenario.control_period_s
    return max(time - SHOWN_S, 0.0), min(time + SHOWN_S, record.scenario.duration_s), time


def source_current(record: DutyRecord) -> Margin | None:
    if not _is_judged(record):
        return None
    means = _source_means(record)
    if means is None:
        return None
    period = record.scenario.control_period_s
    return worst(
        _mean_current(sign * means, limit, verb, period) for sign, limit, verb in _source_limits(record)
    )


def source_moment(record: DutyRecord) -> Moment | None:
    """Show the means of the source's current around the one that decides."""
    means = _source_means(record) if _is_judged(record) else None
    if means is None:
        return None
    period = record.scenario.control_period_s
    sign, limit, verb = min(
        _source_limits(record), key=lambda each: at_most(max(float(np.max(each[0] * means)), 0.0), each[1])
    )
    place = int(np.argmax(sign * means))
    count = round(SHOWN_S / period)
    # Each mean is drawn at its end.
    rows = slice(max(place - count, 0), min(place + count, len(means)))
    times = np.arange(rows.start, rows.stop) * period + MEAN_S
    return Moment(
        start_s=float(times[0]),
        end_s=float(times[-1]),
        quantity="source over 10 ms (A)",
        courses=(course_of("mean", times, means[rows]),),
        levels=(Mark(words=f"limit {limit:.4g} A", value=sign * limit),),
        point=Point(
            words=f"{verb} {sign * means[place]:.4g} A",
            time_s=place * period + MEAN_S,
            value=float(means[place]),
        ),
    )


def _source_means(record: DutyRecord) -> NDArray[np.float64] | None:
    """Return the current of the source over 10 ms from each control period on (A); None for a shorter run."""
    count = max(round(MEAN_S / record.scenario.control_period_s), 1)
    current = record.run.column("source_current")
    if len(current) < count:
        return None
    sums = np.concatenate(([0.0], np.add.accumulate(current)))
    means = (sums[count:] - sums[:-count]) / count
    return np.where(_is_charged_by_steps(record, count), 0.0, means)


def _source_limits(record: DutyRecord) -> list[tuple[float, float, str]]:
    """Return the limits of the source's mean current (A), each with its sign and a verb."""
    link, allowed = record.plant.dc_link, record.limits.source_current
    limits = [(1.0, allowed * link.discharge_limit, "supplies")]
    if link.charge_limit > 0.0:
        limits.append((-1.0, allowed * link.charge_limit, "takes back"))
    return limits


def _mean_current(means: NDArray[np.float64], limit: float, verb: str, period: float) -> Margin:
    place = int(np.argmax(means))
    found = (
        f"the source {verb} {max(float(means[place]), 0.0):.4g} A over 10 ms from {place * period:.4g} s on"
    )
    return Margin("LNK-2", at_most(max(float(means[place]), 0.0), limit), found)


def _is_charged_by_steps(record: DutyRecord, count: int) -> NDArray[np.bool_]:
    """Return in which means a step of the source charges the link, which no controller prevents, shape (n,)."""
    period, link = record.scenario.control_period_s, record.plant.dc_link
    charged = np.zeros(len(record.run.trace) - count + 1, np.bool_)
    slowest = max(
        link.capacitance * link.source_resistance, 2.0 * link.source_inductance / link.source_resistance
    )
    lasting = AFTER_SUPPLY_STEP * slowest
    profile = record.scenario.supply_v or ()
    for time, _ in profile[1:]:
        first = max(round(time / period) - count, 0)
        charged[first : round((time + lasting) / period) + 1] = True
    return charged


def braking_torque(record: DutyRecord) -> Margin | None:
    if not _is_judged(record):
        return None
    return worst(_braking(record, window) for window in record.steady)


def _braking(record: DutyRecord, window: DutyWindow) -> Margin | None:
    wanted, sense = window.torque_reference, sense_of(window.speed)
    if wanted is None or sense * wanted >= 0.0:
        return None
    source, weakens = 2.0 * window.dwell.supply_v, record.document.weakens
    greatest = greatest_braking(record.plant, abs(window.speed), source, weakens)
    if greatest < LEAST_BRAKING * record.document.rating.rated_torque_nm:
        return None
    least = record.limits.link_braking * min(-sense * wanted, greatest)
    found = (
        f"braking torque {-sense * window.torque:.4g} N·m of {-sense * wanted:.4g} N·m, where the link allows "
        f"{greatest:.4g} N·m {at(window)}"
    )
    return Margin("LNK-3", normalised(-sense * window.torque - least, least), found)


def link_swing(record: DutyRecord) -> Margin | None:
    if not _is_judged(record):
        return None
    return worst(_swing(record, window) for window in record.steady)


def swing_moment(record: DutyRecord) -> Moment | None:
    """Show the means of the link in the stretch in which it swings."""
    judged = [(window, _swing(record, window)) for window in record.steady] if _is_judged(record) else []
    least = decisive(judged)
    if least is None:
        return None
    window, _ = least
    rows = record.periods(window.start_s, window.end_s)
    times = (np.arange(rows.start, rows.stop) + 0.5) * record.scenario.control_period_s
    means = record.run.column("link_mean")[rows]
    sign = max((1.0, -1.0), key=lambda way: float(_above(way * means).max()))
    above = _above(sign * means)
    place = int(np.argmax(above))
    swing, peak = float(above[place]), float(means[place])
    return Moment(
        start_s=window.start_s,
        end_s=window.end_s,
        quantity="link (V)",
        courses=(course_of("link", times, means),),
        levels=(Mark(words="where it swings from and to", value=peak - sign * swing),),
        point=Point(words=f"{swing:.4g} V apart", time_s=float(times[place]), value=peak),
    )


def _swing(record: DutyRecord, window: DutyWindow) -> Margin | None:
    rows = record.periods(window.start_s, window.end_s)
    if chopper_burns(record, rows):
        return None
    swing = swing_of(record.run.column("link_mean")[rows])
    limit = record.limits.link_swing * record.document.inverter.link_voltage_v
    return Margin("LNK-4", at_most(swing, limit), f"link swings by {swing:.4g} V {at(window)}")


def swing_of(voltages: NDArray[np.float64]) -> float:
    """Return the greatest swing of voltages, shape (n,), away and back (V); a drift in one direction is none."""
    return max(float(_above(sign * voltages).max()) for sign in (1.0, -1.0))


def _above(voltages: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return by how much each voltage is above both the least earlier and the least later one (V), shape (n,)."""
    earlier = np.minimum.accumulate(voltages)
    later = np.minimum.accumulate(voltages[::-1])[::-1]
    above: NDArray[np.float64] = voltages - np.maximum(earlier, later)
    return above


LNK_1 = Check(
    id="LNK-1",
    families=LINK_FAMILIES,
    requirement="The voltage of the link is at most 100 % of its limit, whatever reference, load and source do.",
    limit="the drive's link_limit_v",
    scenarios="every run of the nominal drive on a link with a capacitor",
    formula="1 - greatest voltage of the link / its limit",
    why="A supply that is pumped up by braking destroys the bridge, and whatever else hangs on it.",
    evaluate=link_limit,
    moment=link_moment,
    reason_not_applicable=_unless_linked,
)
LNK_2 = Check(
    id="LNK-2",
    families=LINK_FAMILIES,
    requirement="The mean current of the source over 10 ms is at most {source_current} of its limits of charging and "
    "discharging.",
    limit="{source_current} of the drive's charge_limit_a and discharge_limit_a",
    scenarios="every run of the nominal drive on a link with a capacitor, but for the time in which a step of the "
    "source charges it",
    formula="1 - mean current / {source_current} of the limit",
    why="A battery's protection disconnects it, and nothing takes the braking energy then.",
    evaluate=source_current,
    moment=source_moment,
    reason_not_applicable=_unless_linked,
)
LNK_3 = Check(
    id="LNK-3",
    families=LINK_FAMILIES,
    requirement="Within the limits of link and source the drive brakes with at least {link_braking} of the torque that "
    "is possible or asked for.",
    limit="{link_braking} of the oracle's greatest braking torque",
    scenarios="steady braking torques of the nominal drive on a link with a capacitor",
    formula="braking torque / ({link_braking} of the lesser of reference and oracle) - 1",
    why="Giving up braking altogether is no way to protect the link: copper and chopper take energy too.",
    evaluate=braking_torque,
    reason_not_applicable=_unless_linked,
)
LNK_4 = Check(
    id="LNK-4",
    families=LINK_FAMILIES,
    requirement="In steady state the voltage of the link swings by at most {link_swing} of the nominal voltage.",
    limit="{link_swing} of the nominal voltage, peak to peak",
    scenarios="steady stretches of the nominal drive in which the chopper is off",
    formula="1 - greatest rise and fall, or fall and rise, of the mean voltage of a control period / {link_swing} of "
    "the nominal voltage",
    why="A regulator of the link that hunts heats its capacitor and shakes the shaft.",
    evaluate=link_swing,
    moment=swing_moment,
    reason_not_applicable=_unless_linked,
)
