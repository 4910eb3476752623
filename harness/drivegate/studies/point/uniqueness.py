"""Whether the periodic state at an operating point is the only one."""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING, Final

import numpy as np

from drivegate_models.machine import ledger
from drivegate_models.machine.period import APERIODIC
from drivegate_models.steady.plant import advance_phases, make_phases, periodic_start

if TYPE_CHECKING:
    from drivegate_models.steady.plant import AnyDrive

_OFFSET: Final = 1e-3
"""Offset that is added to a current, over the current reference and 1 A (1)."""
_DECAY: Final = 1e-6
"""Least share of an offset that a cycle takes off, where the state is the only one (1)."""


def is_unique(drive: AnyDrive, speed: float, advance: float, reference: float) -> bool:
    """Return True if a dc offset of a current does not persist in the periodic state, or if there is no such state.

    Without resistance a current that reaches neither zero nor its limit has nothing that returns it to one state. Speed
    in rad/s, advance in rad electrical, reference in A.
    """
    if drive.resistance > 0.0:
        return True
    state, voltage = make_phases(drive), drive.half_supply_voltage
    periods = periodic_start(drive, state, make_phases(drive), speed, voltage, reference, advance)
    if periods == APERIODIC:
        return True
    cycle = 2.0 * pi / (drive.pole_pairs * speed)
    angle = 0.5 * (pi - drive.window) - advance
    offset = _OFFSET * (1.0 + reference)
    for added in (offset, -offset):
        moved = make_phases(drive)
        for its, found in zip(moved, state, strict=True):
            its[:] = found
        moved.currents[0] += added
        if drive.phases > 1:
            # In a star the sum of the currents stays zero.
            moved.currents[-1] -= added
        start = moved.currents.copy()
        totals = np.zeros(ledger.ENTRIES)
        advance_phases(drive, moved, angle, speed, voltage, voltage, reference, advance, cycle, totals)
        if np.abs(moved.currents - start).max() < _DECAY * offset:
            return False
    return True
