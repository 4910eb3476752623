"""What follows from a scenario's profiles: their layout for compiled code, and where all stand still."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from drivegate_cases.piecewise import Profile, breakpoints, value_from, value_until
from drivegate_cases.scenario import Scenario


@dataclass(frozen=True, slots=True)
class Dwell:
    """A stretch of constant speed reference, load and supply.

    Attributes
    ----------
    start, end : float
        Time at which the stretch begins and ends (s).
    speed_rpm : float
        Speed reference (rpm).
    load_factor : float
        Share of the load; 1 for a locked shaft.
    supply_v : float
        Voltage of each half of the supply (V).
    """

    start: float
    end: float
    speed_rpm: float
    load_factor: float
    supply_v: float

    @property
    def duration(self) -> float:
        """Length of the stretch (s)."""
        return self.end - self.start


def profile_arrays(points: Profile) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lay a profile out for compiled code.

    Parameters
    ----------
    points : tuple of (float, float)
        Times (s) and values.

    Returns
    -------
    times : ndarray, shape (n,)
        Times (s), never decreasing.
    values : ndarray, shape (n,)
        Values at these times, in the profile's own unit.
    """
    table = np.array(points, dtype=np.float64).reshape(-1, 2)
    return np.ascontiguousarray(table[:, 0]), np.ascontiguousarray(table[:, 1])


def dwells(scenario: Scenario) -> tuple[Dwell, ...]:
    """Find the stretches of a scenario in which speed reference, load factor and supply are all constant.

    Parameters
    ----------
    scenario : Scenario
        The scenario.

    Returns
    -------
    tuple of Dwell
        In order of time, each as long as it can be; ramps belong to none.
    """
    profiles = (scenario.speed_rpm, scenario.load_profile, scenario.supply_profile)
    found: list[Dwell] = []
    for start, end in pairwise(breakpoints(profiles, scenario.duration_s)):
        constant = [value_from(points, start) for points in profiles]
        if constant != [value_until(points, end) for points in profiles]:
            continue
        if found and found[-1].end == start and _conditions(found[-1]) == constant:
            found[-1] = replace(found[-1], end=end)
        else:
            found.append(Dwell(start, end, *constant))
    return tuple(found)


def _conditions(dwell: Dwell) -> list[float]:
    return [dwell.speed_rpm, dwell.load_factor, dwell.supply_v]
