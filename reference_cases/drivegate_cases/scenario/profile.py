"""What follows from a scenario's profiles: their layout for compiled code, and where all stand still."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from drivegate_cases.drive.plant import Scales
from drivegate_cases.scenario.control_periods import seen_at_s
from drivegate_cases.scenario.load import LockedLoad
from drivegate_cases.scenario.piecewise import Profile, breakpoints, value_from, value_until
from drivegate_cases.scenario.scenario import Scenario


@dataclass(frozen=True, slots=True)
class Dwell:
    """A stretch in which nothing outside of the controller changes."""

    start: float
    end: float
    """Time at which the stretch begins and ends (s)."""
    speed_rpm: float
    """Speed reference (rpm)."""
    load_factor: float
    """Share of the load; 1 for a locked shaft, the grade (%) for a vehicle."""
    supply_v: float
    """Mean voltage of the halves of the supply (V)."""
    imbalance: float = 0.0
    """Share by which the halves differ from it."""
    resistance_factor: float = 1.0
    emf_factor: float = 1.0
    inertia_factor: float = 1.0
    """Drift of the plant's parameters (1)."""

    @property
    def duration(self) -> float:
        """Length of the stretch (s)."""
        return self.end - self.start


def profile_arrays(
    points: Profile, control_period_s: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lay a profile out for compiled code, its times as the loop sees them."""
    seen = [(seen_at_s(time, control_period_s), value) for time, value in points]
    table = np.array(seen, dtype=np.float64).reshape(-1, 2)
    return np.ascontiguousarray(table[:, 0]), np.ascontiguousarray(table[:, 1])


def dwells(scenario: Scenario) -> tuple[Dwell, ...]:
    """Find the stretches of a scenario in which reference, load, supply, plant and sensors are all constant.

    A restart of the controller ends one, as an event that is over at once.
    """
    profiles = (
        scenario.speed_rpm,
        scenario.load_profile,
        scenario.supply_profile,
        scenario.imbalance_profile,
        scenario.resistance_profile,
        scenario.emf_profile,
        scenario.inertia_profile,
    )
    failures = [(dropout.start_s, dropout.end_s) for dropout in scenario.dropouts]
    failures += [(glitch.time_s, glitch.time_s) for glitch in scenario.glitches]
    failures += [(time, time) for time in scenario.restarts_s]
    # A failure begins at the first of its two points and is over at the second.
    events: tuple[Profile, ...] = tuple(((start, 0.0), (end, 0.0)) for start, end in failures)
    interruptions = {end for _, end in failures}
    found: list[Dwell] = []
    for start, end in pairwise(breakpoints((*profiles, *events), scenario.duration_s)):
        constant = [value_from(points, start) for points in profiles]
        if constant != [value_until(points, end) for points in profiles]:
            continue
        if any(failed <= start and end <= back for failed, back in failures):
            continue
        continues = found and found[-1].end == start and start not in interruptions
        if continues and _conditions(found[-1]) == constant:
            found[-1] = replace(found[-1], end=end)
        else:
            found.append(Dwell(start, end, *constant))
    return tuple(found)


def _conditions(dwell: Dwell) -> list[float]:
    return [
        dwell.speed_rpm,
        dwell.load_factor,
        dwell.supply_v,
        dwell.imbalance,
        dwell.resistance_factor,
        dwell.emf_factor,
        dwell.inertia_factor,
    ]


def dwell_torque(scenario: Scenario, dwell: Dwell) -> float:
    """Return the torque that the load demands while nothing changes."""
    if isinstance(scenario.load, LockedLoad) or dwell.load_factor == 0.0 == dwell.speed_rpm:
        return 0.0
    return scenario.load.torque_at(dwell.speed_rpm, dwell.load_factor)


def dwell_scales(scenario: Scenario, dwell: Dwell) -> Scales:
    """Return the plant's parameters while nothing changes."""
    scales = scenario.scales
    return scales.model_copy(
        update={
            "resistance": scales.resistance * dwell.resistance_factor,
            "emf_constant": scales.emf_constant * dwell.emf_factor,
            "inertia": scales.inertia * dwell.inertia_factor,
        }
    )


def is_after_change(scenario: Scenario, dwell: Dwell) -> bool:
    """Return whether anything has changed before a stretch, or the controller has been restarted."""
    earlier = [other for other in dwells(scenario) if other.start < dwell.start]
    failed = any(dropout.start_s < dwell.start for dropout in scenario.dropouts)
    failed |= any(time <= dwell.start for time in scenario.restarts_s)
    failed |= any(glitch.time_s <= dwell.start for glitch in scenario.glitches)
    return failed or any(dwell_torque(scenario, other) > 0.0 for other in earlier)
