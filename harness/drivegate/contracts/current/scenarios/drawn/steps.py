"""Numbers that scenarios are drawn from: whole steps from nominal."""

from __future__ import annotations

import math
from typing import TypeAlias

from hypothesis import strategies as st

from drivegate.contracts.current.scenarios.building import steady_scenario
from drivegate.scenarios.drive_scale import SpeedRange, loaded_range, scale_of, tidy
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.scenario import Scenario

Drawn: TypeAlias = st.SearchStrategy[Scenario]
"""Scenarios to draw from."""
LOAD_STEP = 0.05
"""Step of drawn loads, as a share of rated power (1)."""
LIGHTEST_STEPS = 18
"""Greatest number of these steps below rated power."""
EARLIEST_STEPS = 18
"""Greatest number of steps by which a change comes before a search has converged."""


def steps_between(lowest: float, highest: float, step: float) -> st.SearchStrategy[float]:
    """Draw a speed of whole steps, simplest at the highest."""
    top = math.floor(highest / step + 1e-9)
    bottom = math.ceil(lowest / step - 1e-9)
    if bottom > top:
        return st.just(highest)
    return st.integers(0, top - bottom).map(lambda slower: tidy(step * (top - slower)))


def loaded_speeds(drive: DriveDocument, speed_range: SpeedRange | None) -> st.SearchStrategy[float]:
    return steps_between(*loaded_range(drive, speed_range), scale_of(drive).speed_step_rpm)


def shares(lightest: int = LIGHTEST_STEPS) -> st.SearchStrategy[float]:
    return st.integers(0, lightest).map(lambda lighter: round(1.0 - LOAD_STEP * lighter, 2))


def change_times(drive: DriveDocument) -> st.SearchStrategy[float]:
    scale = scale_of(drive)
    return st.integers(0, EARLIEST_STEPS).map(
        lambda earlier: tidy(scale.change_s - scale.change_step_s * earlier)
    )


def nonzero(greatest: int) -> st.SearchStrategy[int]:
    """Draw a whole number other than 0."""
    sizes = st.integers(1, greatest)
    return st.builds(lambda size, negative: -size if negative else size, sizes, st.booleans())


def steady_runs(
    drive: DriveDocument, speed_range: SpeedRange | None, *, lightest: int = LIGHTEST_STEPS
) -> Drawn:
    """Draw runs at one speed under one load, of constant torque or constant power."""
    return st.builds(
        lambda constant_power, share, speed: steady_scenario(
            drive, speed, power_share=share, constant_power=constant_power
        ),
        st.booleans(),
        shares(lightest),
        loaded_speeds(drive, speed_range),
    )
