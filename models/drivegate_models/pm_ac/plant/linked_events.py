"""Events of a link with a capacitor: source, chopper and an empty capacitor; and of legs whose voltages follow it."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.machine.rotor_frame import RotorFrame
from drivegate_models.pm_ac.plant.circuit import Circuit
from drivegate_models.pm_ac.plant.dc_link import (
    BATTERY,
    CHOPPER,
    CLAMPED,
    CURRENT,
    SOURCE,
    VOLTAGE,
    LinkState,
)
from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.pm_ac.plant.events import (
    BEYOND,
    NOTHING,
    ONSET,
    RELEASE,
    SLACK,
    Event,
    emf_series,
    last_zero,
)
from drivegate_models.pm_ac.plant.modulator import LOWER, UPPER
from drivegate_models.pm_ac.plant.polynomial import NOWHERE, first_fall, size_of
from drivegate_models.pm_ac.plant.series import Series, turning_series
from drivegate_models.pm_ac.plant.settling import Legs

BLOCKED: Final = 10
"""The current of a source that takes none back has fallen to zero."""
CONDUCTING: Final = 11
"""The link has fallen to the voltage of such a source."""
CHOPPER_ON: Final = 12
"""The link has risen to the chopper's upper threshold."""
CHOPPER_OFF: Final = 13
"""The link has fallen to the chopper's lower threshold."""
EMPTIED: Final = 14
"""The capacitor is empty, and the bridge's diodes keep it at 0 V."""
CHARGED: Final = 15
"""The source supplies more than the bridge takes from an empty capacitor."""


class LinkEvent(NamedTuple):
    """The first event of the link in a segment."""

    kind: int
    """One of the kinds of this module, or `events.NOTHING`."""
    share: float
    """Time of the event, as a share of the segment's length (1)."""


@inlined
def _passing(series: NDArray[np.float64], count: int, level: float, side: int, scale: float) -> float:
    """Return the share at which a series passes a level: downward from above with `side` 1, upward with -1.

    `scale` is that of the drive, without which a series that begins at zero would have none.
    """
    start = series[0]
    slack = SLACK * (size_of(series, count) + abs(level) + scale)
    series[0] = start - level
    share = first_fall(series, count, float(side), 0.0, slack)
    series[0] = start
    return share


@inlined
def _earlier(first: LinkEvent, kind: int, share: float) -> LinkEvent:
    if share < first.share or (share <= 1.0 and first.kind == NOTHING):
        return LinkEvent(kind, share)
    return first


@inlined
def voltage_range(link: LinkState, count: int) -> tuple[float, float, bool]:
    """Return bounds of the link's voltage in a segment (V), and whether they are exact because it is monotone."""
    voltage = link.voltage
    end = 0.0
    deviation = 0.0
    for k in range(count):
        end += voltage[k]
        deviation += k * (k - 1) * abs(voltage[k])
    deviation *= 0.125
    lowest, highest = min(voltage[0], end), max(voltage[0], end)
    if highest - lowest > 8.0 * deviation:
        return lowest, highest, True
    return lowest - deviation, highest + deviation, False


@inlined
def _passing_supply(drive: PmAcDrive, link: LinkState, source: float, count: int) -> float:
    """Return the share at which the current into the bridge falls below that of the source, at an empty capacitor."""
    constants = drive.dc_link
    if link.state[SOURCE] == 0.0:
        return _passing(link.bridge, count, 0.0, 1, drive.current_limit)
    if constants.source_inductance == 0.0:
        return _passing(link.bridge, count, source / constants.source_resistance, 1, drive.current_limit)
    for k in range(count):
        link.product[k] = link.bridge[k] - link.source[k]
    return _passing(link.product, count, 0.0, 1, drive.current_limit)


@unallocating
def link_event(
    drive: PmAcDrive, link: LinkState, source: float, count: int, follows_thresholds: bool
) -> LinkEvent:
    """Return the first event of the link in a segment.

    `link`: with the series of its voltage and of the bridge's current. `source`: voltage of the source (V), 0 if it is
    disconnected. `count`: number of coefficients. `follows_thresholds`: True if the chopper is not commanded.
    """
    constants = drive.dc_link
    scale = drive.link_voltage
    state = link.state
    voltage = link.voltage
    first = LinkEvent(NOTHING, 1.0)
    if state[CLAMPED] != 0.0:
        return _earlier(first, CHARGED, _passing_supply(drive, link, source, count))
    lowest, highest, _ = voltage_range(link, count)
    if lowest <= 0.0:
        first = _earlier(first, EMPTIED, _passing(voltage, count, 0.0, 1, scale))
    if constants.source != BATTERY and source > 0.0:
        if state[SOURCE] != 0.0 and constants.source_inductance > 0.0:
            first = _earlier(first, BLOCKED, _passing(link.source, count, 0.0, 1, drive.current_limit))
        elif state[SOURCE] != 0.0:
            if highest >= source:
                first = _earlier(first, BLOCKED, _passing(voltage, count, source, -1, scale))
        elif lowest <= source:
            first = _earlier(first, CONDUCTING, _passing(voltage, count, source, 1, scale))
    if follows_thresholds and constants.chopper_conductance > 0.0:
        if state[CHOPPER] == 0.0:
            if highest >= constants.chopper_on:
                first = _earlier(first, CHOPPER_ON, _passing(voltage, count, constants.chopper_on, -1, scale))
        elif lowest <= constants.chopper_off:
            first = _earlier(first, CHOPPER_OFF, _passing(voltage, count, constants.chopper_off, 1, scale))
    return first


@inlined
def enter_link_event(link: LinkState, kind: int) -> None:
    """Change the state of the link after an event."""
    state = link.state
    if kind == BLOCKED:
        state[SOURCE] = 0.0
        state[CURRENT] = 0.0
    elif kind == CONDUCTING:
        state[SOURCE] = 1.0
    elif kind == CHOPPER_ON:
        state[CHOPPER] = 1.0
    elif kind == CHOPPER_OFF:
        state[CHOPPER] = 0.0
    elif kind == EMPTIED:
        state[CLAMPED] = 1.0
        state[VOLTAGE] = 0.0
    elif kind == CHARGED:
        state[CLAMPED] = 0.0


@unallocating
def end_of_linked_hold(legs: Legs, series: Series, link: LinkState, held: int, count: int) -> Event:
    """Return the first event of the legs in a segment in which a leg is held, as `events.end_of_hold` does.

    The voltages at which the held leg conducts follow the link.
    """
    first = last_zero(legs, series, held, count)
    scale = SLACK * (size_of(series.holding, count) + abs(legs.low[held]) + abs(legs.high[held]))
    gap = link.product
    for side in (-1, 1):
        # The rail of the device that would carry the current, whose voltage the first coefficient contains.
        is_upper = legs.gates[held] != LOWER if side < 0 else legs.gates[held] == UPPER
        gap[0] = series.holding[0] - (legs.high[held] if side < 0 else legs.low[held])
        for k in range(1, count):
            gap[k] = series.holding[k] - (link.voltage[k] if is_upper else 0.0)
        share = first_fall(gap, count, float(side), 0.0, scale)
        if share < first.share or (share <= 1.0 and first.kind == NOTHING):
            first = Event(RELEASE, share, held, side)
    return first


@unallocating
def begin_of_linked_current(
    circuit: Circuit,
    legs: Legs,
    series: Series,
    link: LinkState,
    frame: RotorFrame,
    count: int,
    length: float,
) -> Event:
    """Return the event at which the first current begins while none flows, as `events.begin_of_current` does."""
    first = Event(NOTHING, 1.0, -1, 0)
    turning_series(series.cosine, series.sine, count, frame.cosine, frame.sine, circuit.electrical * length)
    slack = BEYOND * circuit.tie
    for j in range(3):
        for k in range(3):
            if j == k:
                continue
            emf_series(circuit, series, j, k, count)
            series.other[0] += legs.high[k] - legs.low[j]
            rails = (0.0 if legs.gates[k] == LOWER else 1.0) - (1.0 if legs.gates[j] == UPPER else 0.0)
            for n in range(1, count):
                series.other[n] += rails * link.voltage[n]
            share = first_fall(series.other, count, 1.0, 0.0, slack) if slack > 0.0 else NOWHERE
            if share < first.share or (share <= 1.0 and first.kind == NOTHING):
                first = Event(ONSET, share, -1, 0)
    return first
