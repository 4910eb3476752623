"""Conversion of duty ratios to the instants at which the gates of the legs change in a control period."""

from __future__ import annotations

from math import floor
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.contract.duty.signals import LEG_HIGH, LEG_LOW, LEG_OFF
from drivegate_models.pm_ac.plant.drive import CENTRED, RISING, Modulator

UPPER: Final = 1
"""Gate of a leg: the upper switch is on."""
LOWER: Final = -1
"""Gate of a leg: the lower switch is on."""
BLANKED: Final = 0
"""Gate of a leg: neither switch is on."""

_EDGES = 8
_NONE = -1.0


class Gates(NamedTuple):
    """State of the modulator of each leg, and its schedule for one control period; updated in place."""

    levels: NDArray[np.int64]
    """Command of each leg's modulator, shape (3,): `UPPER` or `LOWER`."""
    waits: NDArray[np.float64]
    """Remaining dead time of each leg, shape (3,) (s); negative if there is none."""
    times: NDArray[np.float64]
    """Times at which the gate of each leg changes, from the period's start, shape (3, n) (s); the first is 0."""
    gates: NDArray[np.int64]
    """Gate after each of these times, shape (3, n)."""
    counts: NDArray[np.int64]
    """Number of entries of each leg, shape (3,)."""


def make_gates() -> Gates:
    """Return modulators that have commanded the lower switches for a long time."""
    return Gates(
        np.full(3, LOWER, np.int64),
        np.full(3, _NONE),
        np.zeros((3, _EDGES)),
        np.zeros((3, _EDGES), np.int64),
        np.zeros(3, np.int64),
    )


@inlined
def settled_ratio(modulator: Modulator, ratio: float, period: float) -> float:
    """Return the effective duty ratio of a modulator for a commanded one.

    `ratio`: commanded share of the period with the upper switch on (1). `period`: control period (s). Result: from 0
    to 1, in steps of the counter, without pulses or gaps that are too short (1).
    """
    settled = min(max(ratio, 0.0), 1.0)
    if modulator.counter_levels > 0.0:
        settled = floor(settled * modulator.counter_levels + 0.5) / modulator.counter_levels
    if settled * period < modulator.minimum_pulse:
        return 0.0
    if (1.0 - settled) * period < modulator.minimum_pulse:
        return 1.0
    return settled


@inlined
def _pulse(alignment: int, ratio: float, period: float) -> tuple[float, float]:
    """Return start and end of the upper switch's pulse, before dead time (s)."""
    if ratio >= 1.0:
        return 0.0, period
    if alignment == CENTRED:
        return 0.5 * (1.0 - ratio) * period, 0.5 * (1.0 + ratio) * period
    if alignment == RISING:
        return (1.0 - ratio) * period, period
    return 0.0, ratio * period


@inlined
def _enter(gates: Gates, leg: int, time: float, gate: int) -> None:
    """Add a change of a gate at a time (s) to the schedule; at time 0 it replaces the first entry."""
    index = gates.counts[leg] if time > 0.0 else 0
    gates.times[leg, index] = max(time, 0.0)
    gates.gates[leg, index] = gate
    gates.counts[leg] = index + 1


@inlined
def _command(gates: Gates, leg: int, time: float, level: int, dead_time: float) -> None:
    """Schedule a modulator's command of a level from a time on, with dead time (s)."""
    if level == gates.levels[leg]:
        return
    wait = gates.waits[leg]
    if 0.0 <= wait < time:
        _enter(gates, leg, wait, gates.levels[leg])
    gates.levels[leg] = level
    if dead_time > 0.0:
        _enter(gates, leg, time, BLANKED)
        gates.waits[leg] = time + dead_time
    else:
        _enter(gates, leg, time, level)
        gates.waits[leg] = _NONE


@unallocating
def schedule_gates(
    modulator: Modulator,
    gates: Gates,
    ratios: NDArray[np.float64],
    legs: NDArray[np.int64],
    alignment: int,
    period: float,
) -> None:
    """Write the schedule of all gates for one control period.

    `gates`: state of the modulators, updated; receives the schedule. `ratios`, shape (3,): commanded duty ratios (1).
    `legs`, shape (3,): `LEG_OFF`, `LEG_PWM`, `LEG_HIGH` or `LEG_LOW` of the contract. `alignment`: `CENTRED`, `RISING`
    or `FALLING`. `period`: control period (s).
    """
    dead_time = modulator.dead_time
    for leg in range(3):
        gates.counts[leg] = 1
        gates.times[leg, 0] = 0.0
        gates.gates[leg, 0] = BLANKED if gates.waits[leg] > 0.0 else gates.levels[leg]
        ratio = settled_ratio(modulator, ratios[leg], period)
        if legs[leg] == LEG_HIGH:
            ratio = 1.0
        elif legs[leg] == LEG_LOW:
            ratio = 0.0
        begin, end = _pulse(alignment, ratio, period)
        _command(gates, leg, 0.0, UPPER if begin <= 0.0 < end else LOWER, dead_time)
        if 0.0 < begin < end:
            _command(gates, leg, begin, UPPER, dead_time)
        if begin < end < period:
            _command(gates, leg, end, LOWER, dead_time)
        if 0.0 <= gates.waits[leg] < period:
            _enter(gates, leg, gates.waits[leg], gates.levels[leg])
            gates.waits[leg] = _NONE
        elif gates.waits[leg] >= period:
            gates.waits[leg] -= period
        if legs[leg] == LEG_OFF:
            gates.counts[leg] = 1
            gates.gates[leg, 0] = BLANKED
