"""Numbers that scenarios are drawn from as whole steps, and plain runs."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Final, TypeAlias

from hypothesis import strategies as st

from drivegate.contracts.duty.scenarios.building import (
    load_step_scenario,
    share_scenario,
    speed_scenario,
    torque_of,
)
from drivegate.contracts.duty.scenarios.drawn_range import HEAVIEST_SHARE, SHARE_STEP, TURNING_SHARE
from drivegate.scenarios.drive_scale import tidy
from drivegate_cases.drive.limits import nearest_step
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import Scenario

Drawn: TypeAlias = st.SearchStrategy[Scenario]
"""Scenarios to draw from."""
GREATEST_SEED: Final = 10_000
"""Greatest seed of sensors that is drawn; the least is 1."""


def speeds_between(drive: PmAcDocument, lowest: float, highest: float) -> st.SearchStrategy[float]:
    """Draw a speed in steps of about 2 % of base speed (rpm)."""
    step = nearest_step(0.02 * drive.rating.base_speed_rpm)
    return st.integers(int(-(-lowest // step)), int(highest // step)).map(lambda count: tidy(count * step))


def any_speed(drive: PmAcDocument) -> st.SearchStrategy[float]:
    """Draw a speed from standstill, or without a sensor from twice the least speed, to the highest one (rpm)."""
    highest = drive.rating.highest_speed_rpm
    return speeds_between(drive, min(2.0 * drive.least_speed_rpm, highest), highest)


def turning_speeds(drive: PmAcDocument) -> st.SearchStrategy[float]:
    """Draw a speed from a tenth of base speed to the highest one (rpm)."""
    return speeds_between(drive, TURNING_SHARE * drive.rating.base_speed_rpm, drive.rating.highest_speed_rpm)


def speeds_up_to_base(drive: PmAcDocument) -> st.SearchStrategy[float]:
    """Draw a speed from a tenth of base speed to base speed (rpm)."""
    base = drive.rating.base_speed_rpm
    return speeds_between(drive, TURNING_SHARE * base, base)


def shares_between(lowest: float, highest: float) -> st.SearchStrategy[float]:
    """Draw a share of rated torque (1)."""
    steps = st.integers(round(lowest / SHARE_STEP), round(highest / SHARE_STEP))
    return steps.map(lambda count: round(SHARE_STEP * count, 2))


def runs_from_below(drive: PmAcDocument) -> st.SearchStrategy[Callable[..., Scenario]]:
    """Draw runs that begin below base speed, where no controller must know the plant to hold the current.

    Each is long enough for the `inertia_factor` that it is called with.
    """
    base = drive.rating.base_speed_rpm
    speeds = st.builds(
        lambda share, first, second: partial(
            speed_scenario,
            drive,
            (first, second),
            torque_nm=torque_of(drive, max(first, second), share),
            initial_speed_rpm=min(first, base),
        ),
        shares_between(0.0, 0.7),
        turning_speeds(drive),
        turning_speeds(drive),
    )
    loads = st.builds(
        lambda shares, speed: partial(
            load_step_scenario,
            drive,
            speed,
            torque_of(drive, speed, 1.0),
            shares,
            initial_speed_rpm=min(speed, base),
        ),
        st.tuples(shares_between(0.0, HEAVIEST_SHARE), shares_between(0.0, HEAVIEST_SHARE)),
        turning_speeds(drive),
    )
    return st.one_of(speeds, loads)


def held_or_loaded_runs(drive: PmAcDocument) -> Drawn:
    """Draw runs at one operating point up to base speed, of a torque or of a speed."""

    def made(share: float, speed: float, gives_torque: bool) -> Scenario:
        if gives_torque:
            return share_scenario(drive, speed, share)
        return speed_scenario(drive, (speed,), torque_nm=torque_of(drive, speed, share))

    return st.builds(made, shares_between(0.1, 0.7), speeds_up_to_base(drive), st.booleans())
