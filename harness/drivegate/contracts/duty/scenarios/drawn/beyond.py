"""Drawn runs above the highest speed."""

from __future__ import annotations

from hypothesis import strategies as st

from drivegate.contracts.duty.scenarios.beyond import LAST_STRETCH, speed_beyond
from drivegate.contracts.duty.scenarios.building import share_scenario
from drivegate.contracts.duty.scenarios.drawn.steps import Drawn, shares_between
from drivegate.contracts.duty.scenarios.drawn_range import BRAKING_SHARE
from drivegate_cases.drive.pm_ac.document import PmAcDocument


def overspeed_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw braking torques up to the rated one, and none, between the highest speed and overspeed."""
    torques = shares_between(-BRAKING_SHARE, 0.0)
    return st.builds(
        lambda shares, place: share_scenario(drive, speed_beyond(drive, place), *shares),
        st.tuples(st.just(0.0) | torques, torques, torques),
        st.sampled_from((0.1, 0.25, 0.5, 0.75, 0.9, LAST_STRETCH)),
    )
