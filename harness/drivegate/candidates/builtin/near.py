"""Controllers that are right, but near a limit by design: no check may accuse one of them.

Each is the reference with one alteration, made as those of the faulty controllers are, just within a tolerance.
"""

from __future__ import annotations

from math import radians
from types import MappingProxyType
from typing import Final

from drivegate.candidates.builtin.faults.mutation import Mutation
from drivegate_models.half_bridge.faults import state as faults
from drivegate_models.units import RADIANS_PER_RPM

KIND: Final = "Near a limit"

_ALL: Final = (
    Mutation(
        "speed-offset",
        KIND,
        "Keeps the speed 4.5 rpm too high, where k1 is 5 rpm.",
        "",
        fault=faults.SPEED_BIASED,
        size=4.5 * RADIANS_PER_RPM,
    ),
    Mutation(
        "beside-the-optimum",
        KIND,
        "Rests 0.5° above the angle that it has found.",
        "",
        fault=faults.RESTS_BESIDE,
        size=radians(0.5),
    ),
    Mutation(
        "power-almost-a-billionth-off",
        KIND,
        "Estimates an input power that is 0.92e-9 too high, where 1e-9 is allowed.",
        "",
        fault=faults.ESTIMATE_SCALED,
        size=1.0 + 0.92e-9,
    ),
    Mutation(
        "advances-from-540-rpm",
        KIND,
        "Begins the advance at 540 rpm, where rated power is required from 550 rpm.",
        "",
        factors=(("advance_begins", 540.0 / 510.0),),
    ),
    Mutation(
        "gain-doubled",
        KIND,
        "Has twice the gain in its speed regulator, and so twice the answer to the noise of the measured speed.",
        "",
        factors=(("proportional", 2.0), ("integral_step", 2.0)),
    ),
    Mutation(
        "stops-early",
        KIND,
        "Takes k2 six times too large, and rests where the optimum is near.",
        "",
        factors=(("power_tolerance", 6.0),),
    ),
)

NEAR_DESIGNS: Final = MappingProxyType({mutation.name: mutation for mutation in _ALL})
"""Every one of them by its name."""
