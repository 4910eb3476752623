"""Runs that strain a dc link with a capacitor: more braking than it takes, more power, a lost source."""

from __future__ import annotations

from itertools import pairwise
from typing import Final

from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.scenarios.building import share_scenario
from drivegate.contracts.duty.scenarios.drawn_range import speed_of
from drivegate.scenarios.changes import in_steps
from drivegate.scenarios.title import titled
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import Scenario

BRAKING: Final = -2.0
"""Braking torque over rated torque (1)."""
DRIVING: Final = 1.2
"""Driving torque over rated torque (1)."""
LOST_S: Final = 0.02
"""Time for which the source is lost (s)."""
LOST_SHARE: Final = 0.1
"""Voltage of a lost source over the nominal one: a rectifier blocks (1)."""


def linked_scenarios(drive: PmAcDocument) -> list[Scenario]:
    """Make the fixed runs of a link that is not ideal."""
    if drive.real_link is None:
        return []
    slow, base, fast = (speed_of(drive, place) for place in (-0.5, 0.0, 0.5))
    runs = [
        share_scenario(drive, slow, 0.5, BRAKING),
        share_scenario(drive, base, 0.5, BRAKING, 0.5),
        share_scenario(drive, fast, 0.0, BRAKING),
        share_scenario(drive, base, 0.0, DRIVING),
        share_scenario(drive, fast, 0.0, DRIVING),
    ]
    return [*runs, *_lost(drive, slow)]


def _lost(drive: PmAcDocument, speed_rpm: float) -> list[Scenario]:
    """Make the run in which a rectifier has no voltage for some milliseconds."""
    link = drive.real_link
    if link is None or link.source != "rectifier":
        return []
    run = share_scenario(drive, speed_rpm, 0.3)
    nominal, period = drive.inverter.supply_voltage_v, drive.control_period_s
    begin = round(0.3 * run.duration_s / period) * period
    end = begin + round(LOST_S / period) * period
    halves = in_steps((nominal, LOST_SHARE * nominal, nominal), (begin, end))
    lost = titled(run.replaced(duration_s=2.0 * run.duration_s, supply_v=halves))
    return [lost] if unfair_supply(lost) is None else []


def unfair_supply(scenario: Scenario) -> str | None:
    """State why the source alone charges a link beyond its limit, which no controller prevents."""
    document = duty_document(scenario.drive)
    link = document.real_link
    if link is None or link.overshoot == 0.0:
        return None
    limit = link.limit(document.inverter.link_voltage_v)
    voltages = [2.0 * half for _, half in scenario.supply_v or ()]
    if any(now + link.overshoot * max(now - before, 0.0) > limit for before, now in pairwise(voltages)):
        return "a step of its source alone, with the source's inductance, charges the link beyond its limit"
    return None
