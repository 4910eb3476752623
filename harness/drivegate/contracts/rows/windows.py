"""Where in a run a row is judged."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate.checks.stretches import stretches
from drivegate.contracts.contract import Contract
from drivegate.contracts.rows.events import Occurrence, changes, follows, is_alone, occurrences
from drivegate_cases.requirements.quantities import QUANTITIES, Columns
from drivegate_cases.requirements.row import Row, When
from drivegate_cases.requirements.vocabulary import TIME_UNITS
from drivegate_cases.scenario.control_periods import first_period_from
from drivegate_cases.scenario.scenario import Scenario

_ROUNDING: Final = 1e-9


@dataclass(frozen=True)
class Span:
    """A stretch of a run that follows an event or a state."""

    origin_s: float
    """Time of the event, or at which the state begins (s)."""
    start: int
    end: int
    """First control period of it, and the one after its last."""
    is_whole: bool = True
    """Whether it is as long as the row states."""


def window_s(row: Row, scenario: Scenario) -> tuple[float, float | None]:
    """Return begin and end of a row's window after its event (s); no end where it states none."""
    unit, (begin, end) = row.window
    length = TIME_UNITS[unit].seconds(scenario.drive, scenario.control_period_s)
    return begin * length, None if end is None else end * length


def stretch_periods(row: Row, scenario: Scenario) -> int:
    """Return the length of the stretches that a statistic is taken over, in control periods; 0 for the whole window."""
    if row.for_periods is not None:
        return max(round(row.for_periods), 1)
    return 0 if row.for_s is None else max(first_period_from(row.for_s, scenario.control_period_s), 1)


def is_asked_for(row: Row, contract: Contract, scenario: Scenario) -> bool:
    """Return True if a run of a scenario shows the row's quantity, and has its event."""
    quantity, when = QUANTITIES[row.quantity], row.when
    if quantity.follows and not follows(scenario, quantity.follows):
        return False
    for name, reference in (("speed_reference_rpm", "speed"), ("torque_reference_nm", "torque")):
        if getattr(when, name) is not None and not follows(scenario, reference):
            return False
    return when.event is None or any(True for _ in event_spans(row, contract, scenario))


def lone_occurrences(when: When, contract: Contract, scenario: Scenario) -> tuple[Occurrence, ...]:
    """Return the events that a row waits for: steps and restarts from a steady state, with nothing else at once."""
    assert when.event is not None, "a state has no event"
    found = occurrences(scenario, when.event)
    if not when.alone or not (when.event.startswith("step of") or when.event == "restart"):
        return found
    half = 0.5 * scenario.control_period_s
    settled = contract.settled_until(scenario)
    return tuple(
        each
        for each in found
        if any(abs(end - each.time_s) < half for end in settled)
        and is_alone(scenario, when.event, each.time_s)
    )


def event_spans(row: Row, contract: Contract, scenario: Scenario) -> Iterator[Span]:
    """Go through the windows after the row's event, up to the next change of anything."""
    assert row.when.event is not None, "a state has no event"
    sizes = row.when.step_percent
    later = (*changes(scenario), scenario.duration_s)
    for event in lone_occurrences(row.when, contract, scenario):
        if sizes is None or sizes[0] <= event.size_percent <= sizes[1]:
            span = _after(event, row, scenario, later)
            if span.start < span.end:
                yield span


def _after(event: Occurrence, row: Row, scenario: Scenario, later: tuple[float, ...]) -> Span:
    period = scenario.control_period_s
    begin, end = window_s(row, scenario)
    next_change = min(time for time in later if time > event.time_s + 0.5 * period or time == later[-1])
    cut = min(next_change, scenario.duration_s)
    last = cut if end is None else min(event.time_s + end, cut)
    return Span(
        event.time_s,
        first_period_from(event.time_s + begin, period),
        first_period_from(last, period),
        end is None or event.time_s + end <= cut + 0.5 * period,
    )


def judged_spans(row: Row, contract: Contract, scenario: Scenario, columns: Columns) -> Iterator[Span]:
    """Go through the stretches in which a row is judged; nothing is judged after a failure but by its event."""
    periods = len(columns["time_s"])
    state = in_state(row.when, contract, columns)
    if row.when.event is not None:
        for span in event_spans(row, contract, scenario):
            at = min(first_period_from(span.origin_s, scenario.control_period_s), periods - 1)
            if state is None or state[at]:
                yield Span(span.origin_s, span.start, min(span.end, periods), span.is_whole)
        return
    last = periods
    if scenario.failure is not None:
        last = min(scenario.failure.first_period(scenario.control_period_s), periods)
    begin, end = window_s(row, scenario)
    first, length = (
        first_period_from(begin, scenario.control_period_s),
        None if end is None else first_period_from(end, scenario.control_period_s),
    )
    inside = np.ones(last, dtype=np.bool_) if state is None else state[:last]
    for entered, left in stretches(inside):
        until = left if length is None else min(entered + length, left)
        if entered + first < until:
            whole = length is None or entered + length <= left
            yield Span(entered * scenario.control_period_s, entered + first, until, whole)


def in_state(when: When, contract: Contract, columns: Columns) -> NDArray[np.bool_] | None:
    """Return in which control periods a state holds, shape (n,); None for no state."""
    if not when.has_state:
        return None
    inside = np.ones(len(columns["time_s"]), dtype=np.bool_)
    for name, (low, high) in when.ranges().items():
        # A contract whose supply has two halves shows one of them.
        values = columns[name] if name in contract.signal_names else 2.0 * columns["half_supply_v"]
        # A reference of 750 rpm is in the range [750, 750] whatever its conversion to rad/s rounds.
        slack = _ROUNDING * max(abs(low), abs(high), 1.0)
        inside &= (values >= low - slack) & (values <= high + slack)
    if when.direction is not None:
        speed = columns["speed_rpm"]
        inside &= speed > 0.0 if when.direction == "forward" else speed < 0.0
    return inside
