"""Runs above the highest speed, braking or without torque, up to the last stretch below overspeed."""

from __future__ import annotations

from typing import Final

from drivegate.contracts.duty.scenarios.building import (
    dwell_periods,
    hoist_scenario,
    share_scenario,
    start_s,
    torque_of,
)
from drivegate.scenarios.drive_scale import tidy
from drivegate.scenarios.rotation import mirrored
from drivegate.scenarios.title import titled
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.load import HoistLoad
from drivegate_cases.scenario.scenario import Scenario

LAST_STRETCH: Final = 0.98
"""Greatest share of the range from the highest speed to overspeed at which a drive must not turn itself off (1)."""
LOWERED_SHARE: Final = 0.25
"""Weight that is lowered there, over rated torque at its speed (1)."""


def speed_beyond(drive: PmAcDocument, share: float) -> float:
    """Return a speed by its share of the range from the highest speed to overspeed (rpm)."""
    highest, overspeed = drive.rating.highest_speed_rpm, drive.rating.overspeed_rpm
    return tidy(highest + share * (overspeed - highest))


def beyond_scenarios(drive: PmAcDocument) -> list[Scenario]:
    """Make the fixed run forward, without torque and braking in the last stretch below overspeed."""
    return [share_scenario(drive, speed_beyond(drive, LAST_STRETCH), 0.0, -0.4, -1.0)]


def backward_beyond_scenarios(drive: PmAcDocument) -> list[Scenario]:
    """Make the fixed runs backward: a torque that brakes, and a weight that the speed regulator lowers."""
    held = share_scenario(drive, speed_beyond(drive, 0.3), 0.0, -0.8)
    return [mirrored(held), lowering_scenario(drive, speed_beyond(drive, 0.5), LOWERED_SHARE)]


def lowering_scenario(drive: PmAcDocument, speed_rpm: float, share: float) -> Scenario:
    """Make a run that lowers a weight at a speed backward; the weight comes on slowly, as on a rope that tightens."""
    run = hoist_scenario(drive, (-speed_rpm,), torque_of(drive, speed_rpm, share))
    each = start_s(drive, dwell_periods(drive))
    factor = ((0.0, 0.0), (each, 1.0))
    load = run.load
    assert isinstance(load, HoistLoad), "a weight hangs on a hoist"
    return titled(
        run.replaced(
            duration_s=start_s(drive, 2 * dwell_periods(drive)),
            load=load.model_copy(update={"factor": factor}),
        )
    )
