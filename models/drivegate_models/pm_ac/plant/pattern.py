"""The voltages of all segments of a control period in which no current changes its sign."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine.rotor_frame import HALF_ROOT, from_phases
from drivegate_models.pm_ac.plant.circuit import (
    Circuit,
    has_drops,
    is_on_upper_rail,
    leg_voltages,
)
from drivegate_models.pm_ac.plant.edges import following_edge
from drivegate_models.pm_ac.plant.modulator import Gates
from drivegate_models.pm_ac.plant.rows import (
    ACROSS,
    ALONG,
    DROP,
    GROUP,
    LINK_ACROSS,
    LINK_ALONG,
    MOST,
    TIME,
    WIDTH,
)
from drivegate_models.pm_ac.plant.settling import Legs
from drivegate_models.pm_ac.plant.volt_seconds import add_steady


class Upcoming(NamedTuple):
    """State of each leg at the present segment; each array has shape (3,)."""

    times: NDArray[np.float64]
    """Time of the next change of its voltage (s)."""
    positions: NDArray[np.int64]
    """Present entry of the schedule."""
    following: NDArray[np.int64]
    """Entry that next changes its voltage."""
    voltages: NDArray[np.float64]
    """Present voltage (V)."""
    uppers: NDArray[np.float64]
    """1 while its current is from the upper rail, otherwise 0."""
    volt_seconds: NDArray[np.float64]
    """Integral of its voltage over the period (V s); shape (0,) to compute none."""


class Pattern(NamedTuple):
    """Division of a period into segments."""

    segments: int
    """Number of segments; 0 if there are too many."""
    longest: float
    """Length of the longest segment (s)."""


def make_upcoming(volt_seconds: NDArray[np.float64]) -> Upcoming:
    return Upcoming(
        np.zeros(3),
        np.zeros(3, np.int64),
        np.zeros(3, np.int64),
        np.zeros(3),
        np.zeros(3),
        np.zeros_like(volt_seconds),
    )


@inlined
def _enter(
    circuit: Circuit, legs: Legs, gates: Gates, upcoming: Upcoming, leg: int, position: int, duration: float
) -> None:
    """Set the state of a leg to an entry of its schedule."""
    gate = gates.gates[leg, position]
    sign = legs.signs[leg]
    low, high = leg_voltages(circuit, gate)
    voltage = low if sign > 0 else high
    following = following_edge(circuit, gates, leg, position, sign, voltage)
    upcoming.voltages[leg] = voltage
    upcoming.uppers[leg] = 1.0 if is_on_upper_rail(gate, sign) else 0.0
    upcoming.following[leg] = following
    upcoming.times[leg] = gates.times[leg, following] if following < gates.counts[leg] else duration


@inlined
def _write(circuit: Circuit, legs: Legs, upcoming: Upcoming, rows: NDArray[np.float64], n: int) -> None:
    """Write voltages, link currents and drops of a segment."""
    voltages = upcoming.voltages
    rows[ALONG + n], rows[ACROSS + n] = from_phases(voltages[0], voltages[1], voltages[2])
    first, second, third = upcoming.uppers[0], upcoming.uppers[1], upcoming.uppers[2]
    # The link carries the sum of the currents of the legs on the upper rail, which is zero with all three.
    rows[LINK_ALONG + n] = first - 0.5 * (second + third)
    rows[LINK_ACROSS + n] = HALF_ROOT * (second - third)
    if not has_drops(circuit):
        return
    for leg in range(3):
        is_switch = (upcoming.uppers[leg] > 0.0) == (legs.signs[leg] > 0)
        rows[DROP + leg * WIDTH + n] = circuit.switch_drop if is_switch else circuit.diode_drop


@inlined
def lay_out(
    circuit: Circuit,
    legs: Legs,
    gates: Gates,
    upcoming: Upcoming,
    begin: float,
    duration: float,
    rows: NDArray[np.float64],
) -> Pattern:
    """Divide a period, from a time in it on, into segments of constant voltages, if no current changes its sign.

    `begin`: that time, up to which the gates are passed (s). `duration`: length of the period (s). `rows`: receives the
    rows of this module; after the last segment the time is `duration`.
    """
    for leg in range(3):
        _enter(circuit, legs, gates, upcoming, leg, legs.positions[leg], duration)
    upcoming.volt_seconds[:] = 0.0
    count = 0
    longest = 0.0
    time = begin
    while time < duration:
        if count == MOST:
            return Pattern(0, longest)
        rows[TIME + count] = time
        _write(circuit, legs, upcoming, rows, count)
        limit = min(upcoming.times[0], upcoming.times[1], upcoming.times[2])
        longest = max(longest, limit - time)
        add_steady(upcoming.voltages, limit - time, upcoming.volt_seconds)
        for leg in range(3):
            if upcoming.times[leg] <= limit and limit < duration:
                _enter(circuit, legs, gates, upcoming, leg, upcoming.following[leg], duration)
        time = limit
        count += 1
    for n in range(count, count + GROUP):
        rows[TIME + n] = duration
    return Pattern(count, longest)
