"""Trips that are right: where a scenario leaves what every drive is made for, a controller may take its safe state."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.run import LEGS
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.scenario.courses import COURSES
from drivegate_cases.scenario.load import LockedLoad
from drivegate_cases.scenario.piecewise import Profile, value_from, value_until
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.contract.duty.signals import LEG_LOW, LEG_OFF

LINK_SHARES: Final = (0.85, 1.15)
"""Least and greatest link voltage over the nominal one on which a drive must go on (1)."""
LOST_PERIODS: Final = 10
"""Control periods that a signal is lost for from which on it may count as failed: shorter losses have to be borne."""
_ROUNDING: Final = 1e-6


def claimed_safe(commands: NDArray[np.void]) -> NDArray[np.bool_]:
    """Return in which control periods a controller says that it is in a safe state, shape (n,)."""
    claimed: NDArray[np.bool_] = legs_are_off(commands) | (commands["fault"] != 0)
    return claimed


def legs_are_off(commands: NDArray[np.void]) -> NDArray[np.bool_]:
    """Return in which control periods a controller turns all legs off, shape (n,)."""
    return _legs_are(LEG_OFF, commands)


def legs_are_low(commands: NDArray[np.void]) -> NDArray[np.bool_]:
    """Return in which control periods a controller turns all legs low, shape (n,)."""
    return _legs_are(LEG_LOW, commands)


def _legs_are(state: int, commands: NDArray[np.void]) -> NDArray[np.bool_]:
    all_are: NDArray[np.bool_] = np.logical_and.reduce([commands[leg] == state for leg in LEGS])
    return all_are


def right_trip_s(scenario: Scenario, commands: NDArray[np.void]) -> float | None:
    """Return when a controller has taken its safe state for a reason that a scenario gives it (s); None if it has not.

    It may do so while the reason lasts, and for as long after it as it may take for a failure.
    """
    reasons = tuple(reasons_to_trip(scenario))
    if not reasons:
        return None
    period = scenario.control_period_s
    longest = limits_of(duty_document(scenario.drive)).safe_state_s
    claimed = claimed_safe(commands)
    begins = np.flatnonzero(claimed & ~np.concatenate(([False], claimed[:-1]))) * period
    right = (
        float(time) for time in begins for start, end in reasons if start - period <= time <= end + longest
    )
    return min(right, default=None)


def reasons_to_trip(scenario: Scenario) -> Iterator[tuple[float, float]]:
    """List when a scenario gives a reason to trip, from one time to another (s).

    The link is far from nominal, a sensor's signal is lost for long, or a held shaft turns beyond overspeed.
    """
    nominal, end = COURSES["supply"].nominal_in(scenario.drive), scenario.duration_s
    least, greatest = (share * nominal for share in LINK_SHARES)
    yield from _outside(COURSES["supply"].profile(scenario), least, greatest, end)
    lost = LOST_PERIODS * scenario.control_period_s
    yield from (
        (dropout.start_s, min(dropout.end_s, end))
        for dropout in scenario.dropouts
        if dropout.duration_s >= lost * (1.0 - _ROUNDING)
    )
    if isinstance(scenario.load, LockedLoad):
        overspeed = scenario.drive.rating.overspeed_rpm
        yield from _outside(scenario.speed_rpm, -overspeed, overspeed, end)


def _outside(profile: Profile, least: float, greatest: float, end: float) -> Iterator[tuple[float, float]]:
    """List the stretches between points of a profile in which it leaves a range somewhere (s)."""
    margin = _ROUNDING * max(abs(least), abs(greatest))
    times = [*dict.fromkeys(time for time, _ in profile if time < end), end]
    for first, last in pairwise(times):
        values = value_from(profile, first), value_until(profile, last)
        if min(values) < least - margin or max(values) > greatest + margin:
            yield first, last
