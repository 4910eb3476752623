"""The flowchart of Fig. 4 as a judge: which advance angles it allows, decision by decision.

The flowchart says what one decision does with a speed error, the power W_new, the one before, W_old, and the
change of angle. It leaves open with which W_old and in which direction a search begins, so its first decision is
free. It also leaves open the points of `Reading`; a candidate may take them either way, but has to keep to it.
What it does not leave open: a decision that changes nothing forgets no direction. The paper sets the change to
zero where the speed is off or W repeats; taken as the loss of the sign, no search could begin after a transient.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import product
from typing import Final, NamedTuple

from drivegate.candidates.declaration import FlowchartProfile

LARGEST_ANGLE: Final = math.pi / 2.0
"""Greatest advance angle of the contract (rad electrical)."""
ROUNDING: Final = 1e-12
"""Relative rounding of powers and speed errors, within which a comparison may go either way (1)."""
_DIGITS: Final = 12


class Reading(NamedTuple):
    """What the flowchart leaves open, once decided."""

    power_follows_supply: bool
    """Whether W is the current sum times the measured supply voltage, or the current sum alone."""
    gate_keeps_power: bool
    """Whether W_old stays what it was while the speed is off, or is the power of that decision."""
    stop_keeps_power: bool
    """Whether W_old stays what it was where W repeats, or is the power of that decision."""
    winds_up: bool
    """Whether steps beyond 0° and 90° are remembered, or the angle itself is limited."""


class Sensed(NamedTuple):
    """What a search senses at a decision."""

    error: float
    """Speed reference less speed (rad/s)."""
    current_sum: float
    """Sum of the current magnitudes (A)."""
    supply: float
    """Voltage of a half-source (V)."""
    line: float
    """The candidate's initial angle at that speed (rad)."""


@dataclass(frozen=True)
class SearchState:
    """A search that has followed the flowchart so far, under one reading of it."""

    reading: Reading
    """How the open points are decided."""
    direction: int
    """Sign of the next step, as long as W does not rise."""
    offset: float = 0.0
    """Sum of all steps (rad)."""
    old_power: float | None = None
    """W_old (W); None before the first decision with the gate open."""

    def angle(self, line: float) -> float:
        """Advance angle that the plant sees."""
        return min(max(line + self.offset, 0.0), LARGEST_ANGLE)


def beginnings() -> frozenset[SearchState]:
    """List every search before its first decision."""
    readings = (Reading(*choices) for choices in product((False, True), repeat=len(Reading._fields)))
    return frozenset(SearchState(reading, direction) for reading in readings for direction in (-1, 1))


def allowed(
    searches: Iterable[SearchState],
    sensed: Sensed,
    profile: FlowchartProfile,
    nominal_supply: float,
    *,
    free: bool,
) -> frozenset[SearchState]:
    """Make one decision of Fig. 4 in every way that it allows."""
    return frozenset(
        after for search in searches for after in _decided(search, sensed, profile, nominal_supply, free)
    )


def _decided(
    search: SearchState, sensed: Sensed, profile: FlowchartProfile, nominal_supply: float, free: bool
) -> Iterator[SearchState]:
    reading = search.reading
    power = sensed.current_sum * (sensed.supply if reading.power_follows_supply else nominal_supply)
    excess = abs(sensed.error) - profile.speed_tolerance
    if excess > -ROUNDING * profile.speed_tolerance:
        yield _with(search, search.old_power if reading.gate_keeps_power else power)
    if excess > ROUNDING * profile.speed_tolerance:
        return
    if free or search.old_power is None:
        yield _with(search, power)
        for direction in (-1, 1):
            yield _stepped(search, direction, power, sensed.line, profile.step)
        return
    change = power - search.old_power
    tolerance = profile.power_tolerance + profile.power_tolerance_fraction * power
    rounding = ROUNDING * max(power, search.old_power)
    if abs(change) <= tolerance + rounding:
        yield _with(search, search.old_power if reading.stop_keeps_power else power)
    if abs(change) >= tolerance - rounding:
        if change >= -rounding:
            yield _stepped(search, -search.direction, power, sensed.line, profile.step)
        if change <= rounding:
            yield _stepped(search, search.direction, power, sensed.line, profile.step)


def _with(search: SearchState, old_power: float | None) -> SearchState:
    return SearchState(search.reading, search.direction, search.offset, old_power)


def _stepped(search: SearchState, direction: int, power: float, line: float, step: float) -> SearchState:
    offset = search.offset + direction * step
    if not search.reading.winds_up:
        offset = min(max(offset, -line), LARGEST_ANGLE - line)
    return SearchState(search.reading, direction, round(offset, _DIGITS), power)


def described(sensed: Sensed, before: Sensed, profile: FlowchartProfile) -> str:
    """State which branch of the flowchart a decision is in."""
    rpm = 30.0 / math.pi
    if abs(sensed.error) > profile.speed_tolerance:
        tolerance = profile.speed_tolerance * rpm
        return f"the speed is off by {sensed.error * rpm:+.4g} rpm, more than k1 = {tolerance:.4g} rpm"
    power, old = (signals.current_sum * signals.supply for signals in (sensed, before))
    change = power - old
    tolerance = profile.power_tolerance + profile.power_tolerance_fraction * power
    change_text = f"from {old:.6g} W by {change:+.4g} W"
    if abs(change) <= tolerance:
        return f"W changes {change_text}, no more than k2 = {tolerance:.4g} W"
    return f"W {'rises' if change > 0.0 else 'falls'} {change_text}"
