"""Runs that strain a dc link with a capacitor: more braking than it takes, more power, a lost source."""

from __future__ import annotations

import math
from typing import Final

from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.scenarios.building import share_scenario, supply_step_scenario
from drivegate.contracts.duty.scenarios.drawn_range import speed_of
from drivegate.scenarios.changes import in_steps
from drivegate.scenarios.title import titled
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.units import RADIANS_PER_RPM

BRAKING: Final = -1.2
"""Braking torque over rated torque (1)."""
DRIVING: Final = 1.2
"""Driving torque over rated torque (1)."""
LOST_S: Final = 0.02
"""Time for which the source is lost (s)."""
LOST_SHARE: Final = 0.1
"""Voltage of a lost source over the nominal one: a rectifier blocks (1)."""
CHARGED_SHARE: Final = 0.95
"""Greatest line-to-line EMF at the start of a run over the limit of the link (1)."""


def unfair_link(scenario: Scenario) -> str | None:
    """State why a run charges its link beyond the limit before an answer acts."""
    drive = duty_document(scenario.drive)
    link = drive.real_link
    if link is None:
        return None
    limit = link.limit(drive.inverter.link_voltage_v)
    speed = abs(scenario.initial_speed_rpm) * RADIANS_PER_RPM * drive.machine.pole_pairs
    induced = math.sqrt(3.0) * drive.machine.magnet_flux_v_s * scenario.scales.emf_constant * speed
    if induced > CHARGED_SHARE * limit:
        return "it begins so fast that the diodes alone charge the link to its limit"
    return None


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
    return [run for run in (*runs, *_lost(drive, slow)) if unfair_link(run) is None]


def _lost(drive: PmAcDocument, speed_rpm: float) -> list[Scenario]:
    """Make the run in which a rectifier has no voltage for some milliseconds."""
    link = drive.real_link
    if link is None or link.source != "rectifier":
        return []
    run = supply_step_scenario(share_scenario(drive, speed_rpm, 0.3), drive, (1.0,))
    nominal, period = drive.inverter.supply_voltage_v, drive.control_period_s
    begin = round(0.3 * run.duration_s / period) * period
    end = begin + round(LOST_S / period) * period
    halves = in_steps((nominal, LOST_SHARE * nominal, nominal), (begin, end))
    return [titled(run.replaced(supply_v=halves))]
