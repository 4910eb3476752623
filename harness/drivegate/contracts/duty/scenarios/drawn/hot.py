"""Drawn runs with warm and hot windings."""

from __future__ import annotations

from hypothesis import strategies as st

from drivegate.contracts.duty.scenarios.building import share_scenario
from drivegate.contracts.duty.scenarios.drawn.steps import Drawn, shares_between
from drivegate.contracts.duty.scenarios.hot import WARM_SHARE, hot_run, hot_speeds, sensed_windings
from drivegate_cases.drive.pm_ac.document import PmAcDocument


def may_be_hot(drive: PmAcDocument) -> bool:
    """Return True if controllers see the temperature of windings that the current limit heats to their limit."""
    windings = sensed_windings(drive)
    return windings is not None and windings.current < drive.rating.current_limit_a


def hot_winding_scenarios(drive: PmAcDocument) -> Drawn:
    """Draw torques that warm windings bear, or that hot ones may not."""
    speeds = st.sampled_from(hot_speeds(drive))
    warm = st.builds(
        lambda shares, place: hot_run(share_scenario(drive, hot_speeds(drive)[0], *shares), place),
        st.tuples(shares_between(0.0, 0.9), shares_between(0.1, 0.9)),
        st.sampled_from((0.25, 0.5, WARM_SHARE)),
    )
    hot = st.builds(
        lambda speed, share, place: hot_run(share_scenario(drive, speed, share), place),
        speeds,
        shares_between(0.5, 1.0),
        st.sampled_from((0.96, 0.98, 1.0)),
    )
    return warm | hot
