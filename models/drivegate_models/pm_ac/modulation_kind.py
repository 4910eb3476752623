"""Kinds of modulation, which differ by their zero sequence: continuous, or with one leg clamped to a rail.

The discontinuous kinds have the names of Hava, Kerkman and Lipo, "A high-performance generalized discontinuous PWM
algorithm", IEEE Transactions on Industry Applications, vol. 34, no. 5, 1998.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, Literal, TypeAlias

ModulationKind: TypeAlias = Literal[
    "continuous", "dpwm-min", "dpwm-max", "dpwm-0", "dpwm-1", "dpwm-2", "dpwm-3"
]
"""Name of a kind of modulation, as a manifest states it."""

CONTINUOUS: Final = 0
"""All legs switch: space-vector modulation with equal zero vectors."""
DPWM_MIN: Final = 1
"""The leg of the lowest voltage is clamped to the lower rail, each for 120 degrees ("flat-bottom")."""
DPWM_MAX: Final = 2
"""The leg of the highest voltage is clamped to the upper rail, each for 120 degrees."""
DPWM_0: Final = 3
"""Each leg is clamped twice for 60 degrees, 30 degrees ahead of the peaks of its voltage."""
DPWM_1: Final = 4
"""Each leg is clamped twice for 60 degrees, at the peaks of its voltage."""
DPWM_2: Final = 5
"""Each leg is clamped twice for 60 degrees, 30 degrees after the peaks of its voltage."""
DPWM_3: Final = 6
"""Each leg is clamped four times for 30 degrees, on both sides of the peaks of its voltage."""

MODULATION_NUMBERS: Final[Mapping[ModulationKind, int]] = {
    "continuous": CONTINUOUS,
    "dpwm-min": DPWM_MIN,
    "dpwm-max": DPWM_MAX,
    "dpwm-0": DPWM_0,
    "dpwm-1": DPWM_1,
    "dpwm-2": DPWM_2,
    "dpwm-3": DPWM_3,
}
"""Number of the kernels for each kind."""
ONE_SIDED: Final[frozenset[ModulationKind]] = frozenset({"dpwm-min", "dpwm-max"})
"""Kinds that use one rail alone, so that the torque repeats itself after a third of a cycle, not after a sixth."""
