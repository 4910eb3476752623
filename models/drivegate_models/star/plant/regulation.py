"""Window, comparator and staircase of every phase: the state of the inverter until the next event."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.star.plant.staircase import Circuit, staircase, treads_at
from drivegate_models.star.plant.window import chops, sector_of

_SLACK = 1e-13
"""Relative tolerance of a comparator's level, so that phases of equal current switch together."""


@inlined
def compared(circuit: Circuit, latch: int, along: float) -> int:
    """Return the latch after both comparators have evaluated the current times the sector's sign (A)."""
    if along >= (circuit.reference + circuit.band) * (1.0 - _SLACK):
        return 0
    if along <= max(circuit.reference - circuit.band, 0.0) * (1.0 + _SLACK):
        return 1
    return latch


@inlined
def gate_of(circuit: Circuit, piece: int, latch: int) -> int:
    """Return the switch that is on, or that the ideal regulator uses: 1 upper, -1 lower, 0 none."""
    sector = sector_of(piece)
    if sector == 0 or circuit.reference <= 0.0:
        return 0
    if circuit.band > 0.0 and chops(circuit.regulation, piece):
        return sector * latch
    return sector


@inlined
def regulate(circuit: Circuit, places: NDArray[Any], currents: NDArray[np.float64]) -> float:
    """Set latch, staircase and treads of every phase by its window and its current.

    `currents`, shape (m,): phase currents (A). Result: loss of the switches that have changed (J); 0 for the ideal
    regulator.
    """
    lost = 0.0
    for k in range(places.size):
        place = places[k]
        sector = sector_of(place.piece)
        is_chopped = sector != 0 and chops(circuit.regulation, place.piece)
        if is_chopped:
            place.latch = compared(circuit, place.latch, sector * currents[k])
        gate = gate_of(circuit, place.piece, place.latch)
        if gate != place.gate:
            if circuit.band > 0.0:
                lost += circuit.turn_off_energy if place.gate != 0 else 0.0
                lost += circuit.turn_on_energy if gate != 0 else 0.0
            place.gate = gate
        steps = staircase(gate, is_chopped and circuit.band == 0.0, circuit.reference)
        place.first = steps.first
        place.second = steps.second
        place.below, place.above = treads_at(steps, currents[k])
    return lost


@inlined
def comparator_level(circuit: Circuit, place: Any) -> tuple[float, int]:
    """Return the current at which a phase's comparator switches (A), and the side from which it must be reached.

    The side is 1 for below, -1 for above, and 0 if the comparator does not switch.
    """
    sector = sector_of(place.piece)
    if (
        sector == 0
        or circuit.band <= 0.0
        or circuit.reference <= 0.0
        or not chops(circuit.regulation, place.piece)
    ):
        return 0.0, 0
    if place.latch == 1:
        return sector * (circuit.reference + circuit.band), sector
    return sector * max(circuit.reference - circuit.band, 0.0), -sector
