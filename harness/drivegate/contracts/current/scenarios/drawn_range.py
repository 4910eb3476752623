"""The range that scenarios of the `current` contract are drawn from."""

from __future__ import annotations

from drivegate.scenarios.drawn_range import LIGHTEST_SHARE, NONE, DrawnRange, Interval
from drivegate.scenarios.drive_scale import scale_of
from drivegate_cases.scenario.scenario import Scenario


def drawn_range(scenario: Scenario) -> DrawnRange:
    """Return the range of loaded runs whose controller answers with a current reference and an angle."""
    scale = scale_of(scenario.drive)
    return DrawnRange(
        loaded_rpm=Interval(scale.lowest_loaded_rpm, scale.highest_loaded_rpm),
        idle_rpm=Interval(0.0, scale.highest_loaded_rpm),
        driving_share=Interval(LIGHTEST_SHARE, 1.0),
        braking_share=NONE,
    )
