"""Drawn runs that strain a dc link with a capacitor."""

from __future__ import annotations

from hypothesis import strategies as st

from drivegate.contracts.duty.scenarios.building import share_scenario
from drivegate.contracts.duty.scenarios.drawn.steps import Drawn, shares_between, speeds_between
from drivegate.contracts.duty.scenarios.drawn_range import TURNING_SHARE
from drivegate.contracts.duty.scenarios.linked import BRAKING, DRIVING
from drivegate_cases.drive.pm_ac.document import PmAcDocument


def link_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw braking and driving torques up to more than the rated one, one after the other."""
    torques = shares_between(BRAKING, DRIVING)
    base, highest = drive.rating.base_speed_rpm, drive.rating.highest_speed_rpm
    return st.builds(
        lambda speed, shares: share_scenario(drive, speed, *shares),
        speeds_between(drive, TURNING_SHARE * base, highest),
        st.tuples(torques, shares_between(BRAKING, 0.0), torques),
    )
