"""Checks of a dc link with a capacitor: its voltage, its source's current, and the braking that they leave."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.declaration import Declaration
from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, at_most, normalised
from drivegate.contracts.duty.checks.judged import at, worst
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
"""Time in which a step of the source charges the link, in its time constants with the source's resistance (1)."""
LEAST_BRAKING: Final = 0.05
"""Least of the oracle's greatest braking torque that is judged, over rated torque (1)."""


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
    # What the diodes alone have charged before the first answer acts, nobody prevents.
    begin = int(np.argmax(highest <= limit))
    place = begin + int(np.argmax(highest[begin:]))
    found = f"link at {highest[place]:.4g} V at {place * record.scenario.control_period_s:.4g} s"
    return Margin("LNK-1", at_most(float(highest[place]), limit), found)


def source_current(record: DutyRecord) -> Margin | None:
    if not _is_judged(record):
        return None
    period = record.scenario.control_period_s
    count = max(round(MEAN_S / period), 1)
    current = record.run.column("source_current")
    if len(current) < count:
        return None
    sums = np.concatenate(([0.0], np.add.accumulate(current)))
    means = (sums[count:] - sums[:-count]) / count
    means = np.where(_is_charged_by_steps(record, count), 0.0, means)
    link, allowed = record.plant.dc_link, record.limits.source_current
    limits = [(1.0, link.discharge_limit, "supplies")]
    if link.charge_limit > 0.0:
        limits.append((-1.0, link.charge_limit, "takes back"))
    return worst(_mean_current(sign * means, allowed * limit, verb, period) for sign, limit, verb in limits)


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
    lasting = AFTER_SUPPLY_STEP * link.capacitance * link.source_resistance
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


def _swing(record: DutyRecord, window: DutyWindow) -> Margin | None:
    rows = record.periods(window.start_s, window.end_s)
    if record.run.column("chopper_power")[rows].max() > 0.0:
        # Its own thresholds let the link swing.
        return None
    means = record.run.column("link_mean")[rows]
    swing = float(means.max() - means.min())
    limit = record.limits.link_swing * record.document.inverter.link_voltage_v
    return Margin("LNK-4", at_most(swing, limit), f"link swings by {swing:.4g} V {at(window)}")


LNK_1 = Check(
    id="LNK-1",
    families=LINK_FAMILIES,
    requirement="The voltage of the link is at most 100 % of its limit, whatever reference, load and source do.",
    limit="the drive's link_limit_v",
    scenarios="every run of the nominal drive on a link with a capacitor",
    formula="1 - greatest voltage of the link / its limit",
    why="A supply that is pumped up by braking destroys the bridge, and whatever else hangs on it.",
    evaluate=link_limit,
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
    level="advisory",
    families=LINK_FAMILIES,
    requirement="In steady state the voltage of the link swings by at most {link_swing} of the nominal voltage.",
    limit="{link_swing} of the nominal voltage, peak to peak",
    scenarios="steady stretches of the nominal drive in which the chopper is off",
    formula="1 - (greatest - least mean voltage of a control period) / {link_swing} of the nominal voltage",
    why="A regulator of the link that hunts heats its capacitor and shakes the shaft.",
    evaluate=link_swing,
    reason_not_applicable=_unless_linked,
)
