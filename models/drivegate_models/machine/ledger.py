"""Names of the plant's exact integrals, as indices into one array of totals.

Every entry is a sum over the phases of an integral over time. The entries satisfy::

    UPPER + LOWER = EXCHANGED - 2 RETURNED                                       (sources)
    UPPER + LOWER = R SQUARE + speed IMPULSE + DEVICE + change of L i**2 / 2      (consumption and storage)
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined, unallocating

MAGNITUDE: Final = 0
"""Integral of the magnitudes of the phase currents (A s)."""
SQUARE: Final = 1
"""Integral of the squared phase currents (A2 s)."""
IMPULSE: Final = 2
"""Integral of the electromagnetic torque (N m s)."""
UPPER: Final = 3
"""Energy drawn by windings and devices from the upper half-source (J)."""
LOWER: Final = 4
"""Energy drawn by windings and devices from the lower half-source (J)."""
EXCHANGED: Final = 5
"""Integral of half-source voltage times current magnitude, whatever the direction of the power (J)."""
RETURNED: Final = 6
"""The part of `EXCHANGED` that flows back into a half-source (J)."""
DEVICE: Final = 7
"""Loss in the forward drops of switches and diodes (J)."""
SWITCHING: Final = 8
"""Loss at turn-on and turn-off, drawn from the half-sources in addition to `UPPER` and `LOWER` (J)."""
CORE_SOURCE: Final = 9
"""Core loss of connected phases, drawn from the half-sources in addition to `UPPER` and `LOWER` (J)."""
CORE_DRAG_IMPULSE: Final = 10
"""Impulse of the drag torque by which floating phases supply their core loss (N m s)."""
PEAK: Final = 11
"""Maximum magnitude of any phase current (A); a maximum, not a sum."""
EVENTS: Final = 12
"""Number of intervals between events (1)."""
ENTRIES: Final = 13
"""Length of the array."""


@inlined
def source_energy(totals: NDArray[np.float64]) -> float:
    """Return the net energy drawn from the supply (J), including core and switching losses.

    `totals` are the exact integrals, shape (ENTRIES,).
    """
    return float(totals[UPPER] + totals[LOWER] + totals[CORE_SOURCE] + totals[SWITCHING])


@inlined
def add_period(totals: NDArray[np.float64], period: NDArray[np.float64]) -> None:
    """Add the integrals of one control period to those of a run, both of shape (ENTRIES,).

    The peak of the run becomes the larger of both.
    """
    peak = max(totals[PEAK], period[PEAK])
    for entry in range(ENTRIES):
        totals[entry] += period[entry]
    totals[PEAK] = peak


@unallocating
def stored_energy(drive: Any, currents: NDArray[np.float64]) -> float:
    """Return the energy in the windings, ``sum L i**2 / 2`` (J).

    `drive`: constants of any kind of drive with an `inductance` L (H). `currents`, shape (m,): phase currents (A).
    """
    total = 0.0
    for current in currents:
        total += current * current
    return float(0.5 * drive.inductance * total)
