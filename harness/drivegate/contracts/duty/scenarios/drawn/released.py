"""Drawn runs whose shaft is released under a torque."""

from __future__ import annotations

from hypothesis import strategies as st

from drivegate.contracts.duty.scenarios.drawn.steps import Drawn, speeds_between
from drivegate.contracts.duty.scenarios.released import released_scenario
from drivegate_cases.drive.pm_ac.document import PmAcDocument

_REACHED = 0.95


def released_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw shafts that are held at a speed, and then turned to another by up to half of rated torque."""
    speeds = speeds_between(drive, 0.0, _REACHED * drive.rating.highest_speed_rpm)
    pairs = st.tuples(speeds, speeds).filter(
        lambda pair: abs(pair[1] - pair[0]) > 0.2 * drive.rating.base_speed_rpm
    )
    return pairs.map(lambda pair: released_scenario(drive, *pair))
