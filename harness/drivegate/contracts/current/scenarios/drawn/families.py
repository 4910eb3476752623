"""Scenarios drawn by Hypothesis, as integer steps from nominal, so that they shrink and print well."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, TypeAlias

from hypothesis import strategies as st

from drivegate.contracts.current.scenarios.building import base_speed_scenario, steady_scenario
from drivegate.contracts.current.scenarios.drawn.changes import (
    load_step_scenarios,
    required_point_scenarios,
    speed_step_scenarios,
    supply_scenarios,
    vehicle_scenarios,
)
from drivegate.contracts.current.scenarios.drawn.circumstances import (
    beginning_scenarios,
    fault_scenarios,
    parameter_scenarios,
    phase_scenarios,
    restart_scenarios,
    sensor_scenarios,
)
from drivegate.contracts.current.scenarios.drawn.courses import load_course_scenarios, standstill_scenarios
from drivegate.contracts.current.scenarios.drawn.steps import (
    Drawn,
    loaded_speeds,
    shares,
    steady_runs,
    steps_between,
)
from drivegate.contracts.current.scenarios.feasibility import coasted_rate
from drivegate.scenarios.drive_scale import SpeedRange, scale_of, tidy
from drivegate_cases.drive.drive_document import DriveDocument

Family: TypeAlias = Callable[[DriveDocument, SpeedRange | None], Drawn]
"""From a drive and the speeds that a candidate is made for to scenarios of one kind."""

FALL_SHARE = 0.2
"""Step of the rate at which an unloaded reference falls, as a share of a grain of speed in a unit of time (1)."""


def steady_scenarios(drive: DriveDocument, speed_range: SpeedRange | None = None) -> Drawn:
    """Draw runs at one speed under one load."""
    return steady_runs(drive, speed_range)


def constant_power_scenarios(drive: DriveDocument, speed_range: SpeedRange | None = None) -> Drawn:
    """Draw runs at rated power."""
    return loaded_speeds(drive, speed_range).map(
        lambda speed: steady_scenario(drive, speed, power_share=1.0, constant_power=True)
    )


def overspeed_scenarios(drive: DriveDocument, speed_range: SpeedRange | None = None) -> Drawn:
    """Draw runs beyond the required speeds, at rated power or under any lighter load."""
    step = scale_of(drive).speed_step_rpm
    lowest, highest = drive.rating.highest_speed_rpm + step, drive.rating.overspeed_rpm
    if speed_range is not None:
        lowest, highest = max(lowest, speed_range[0]), min(highest, speed_range[1])
    if lowest > highest:
        return st.nothing()
    speeds = steps_between(lowest, highest, step)
    lighter = st.builds(
        lambda constant_power, share, speed: steady_scenario(
            drive, speed, power_share=share, constant_power=constant_power
        ),
        st.booleans(),
        shares(),
        speeds,
    )
    rated = speeds.map(lambda speed: steady_scenario(drive, speed, power_share=1.0, constant_power=True))
    return st.one_of(rated, lighter)


def base_speed_scenarios(drive: DriveDocument, speed_range: SpeedRange | None = None) -> Drawn:
    """Draw unloaded runs through base speed."""
    scale = scale_of(drive)
    grain, base = scale.speed_grain_rpm, scale.base_speed_rpm
    below, above = min(80, int(base // grain)), min(8, int((scale.highest_loaded_rpm - base) // grain))
    if speed_range is not None:
        below = min(below, int((base - speed_range[0]) // grain))
        above = min(above, int((speed_range[1] - base) // grain))
    if below < 2 or above < 1:
        return st.nothing()
    return st.builds(
        lambda below, above, fall: base_speed_scenario(
            drive,
            scale.around_base(-below),
            scale.around_base(above),
            coasted_rate(drive, tidy(FALL_SHARE * grain * fall / scale.time_unit_s)),
        ),
        st.integers(1, below),
        st.integers(1, above),
        st.integers(4, 10),
    )


FAMILY_GROUPS: Final[tuple[tuple[Family, ...], ...]] = (
    (steady_scenarios, constant_power_scenarios, required_point_scenarios),
    (parameter_scenarios,),
    (load_step_scenarios, load_course_scenarios),
    (sensor_scenarios, phase_scenarios),
    (supply_scenarios, beginning_scenarios),
    (fault_scenarios, restart_scenarios),
    (speed_step_scenarios, standstill_scenarios),
    (base_speed_scenarios, overspeed_scenarios, vehicle_scenarios),
)
"""Families of scenarios that a shard of the search draws from; shards take turns at them."""


def drawn_scenarios(
    drive: DriveDocument, speed_range: SpeedRange | None = None, group: int | None = None
) -> Drawn:
    """Draw a scenario of any family, or of one group of them."""
    groups = FAMILY_GROUPS if group is None else (FAMILY_GROUPS[group % len(FAMILY_GROUPS)],)
    drawn = [family(drive, speed_range) for families in groups for family in families]
    filled = [strategy for strategy in drawn if not strategy.is_empty]
    return st.one_of(filled or [steady_scenarios(drive, speed_range)])
