"""How near a scenario that a row did not judge comes to what the row waits for, in words."""

from __future__ import annotations

from drivegate.contracts.contract import Contract
from drivegate.contracts.rows.events import changes, follows, occurrences
from drivegate.contracts.rows.windows import lone_occurrences, window_s
from drivegate_cases.documents.wording import figure
from drivegate_cases.requirements.quantities import QUANTITIES
from drivegate_cases.requirements.row import Range, Row
from drivegate_cases.scenario.courses import COURSES
from drivegate_cases.scenario.scenario import Scenario

_ANOTHER_REFERENCE, _NO_EVENT, _OTHER_STATE, _UNSETTLED, _OTHER_SIZE = 3.0, 2.0, 1.0, 1.5, 1.0
_COURSES = {
    "speed_rpm": "speed",
    "speed_reference_rpm": "speed",
    "torque_reference_nm": "torque_reference",
}
"""By signal of a state, the course of the scenario that is near it."""


def nearness(row: Row, contract: Contract, scenario: Scenario) -> tuple[float, str]:
    """Return how far a scenario is from what a row waits for, from 0, and why, in a clause."""
    quantity = QUANTITIES[row.quantity]
    if quantity.follows and not follows(scenario, quantity.follows):
        return _ANOTHER_REFERENCE, f"its controller follows no {quantity.follows} reference"
    event = row.when.event
    if event is None:
        return _state(row, scenario)
    found = occurrences(scenario, event)
    if not found:
        return _NO_EVENT, f"it has no {event}"
    alone = lone_occurrences(row.when, contract, scenario)
    if not alone:
        return (
            _UNSETTLED,
            f"its {event} at {figure(found[0].time_s)} s comes before the drive has settled, or with another change",
        )
    found, sizes = alone, row.when.step_percent
    if sizes is not None:
        far, size = min((_outside(each.size_percent, sizes), each.size_percent) for each in found)
        if far > 0.0:
            return _OTHER_SIZE + far / (far + 100.0), f"its {event} is {figure(size)} %"
    needed, _ = window_s(row, scenario)
    ends = (*changes(scenario), scenario.duration_s)
    left = max(
        min((end for end in ends if end > each.time_s), default=scenario.duration_s) - each.time_s
        for each in found
    )
    if left <= needed:
        return (needed - left) / needed, (
            f"the longest time after its {event} without another change is {figure(left)} s, but the window begins "
            f"after {figure(needed)} s"
        )
    return _state(row, scenario)


def _state(row: Row, scenario: Scenario) -> tuple[float, str]:
    """Compare a state with what the scenario requests, since the run itself is not there any more."""
    for signal, limits in row.when.ranges().items():
        course = _COURSES.get(signal)
        if course is None:
            continue
        values = [value for _, value in COURSES[course].profile(scenario)]
        low, high = min(values), max(values)
        gap = max(limits[0] - high, low - limits[1], 0.0)
        if gap > 0.0:
            reached = f"{figure(low)} to {figure(high)}" if low < high else figure(low)
            return _OTHER_STATE + gap / (gap + abs(limits[1]) + abs(limits[0]) + 1.0), (
                f"its {signal} is {reached} by the reference"
            )
    return 0.5, "its run does not come into the state for long enough"


def _outside(value: float, limits: Range) -> float:
    return max(limits[0] - value, value - limits[1], 0.0)
