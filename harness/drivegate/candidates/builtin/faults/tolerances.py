"""Faults just beyond a tolerance; `near` has their counterparts just within it."""

from __future__ import annotations

from math import radians
from typing import Final

from drivegate.candidates.builtin.faults.mutation import Mutation
from drivegate_models.half_bridge.faults import state as faults
from drivegate_models.units import RADIANS_PER_RPM

KIND: Final = "Just beyond a tolerance"

FAULTS: Final = (
    Mutation(
        "angle-cycles",
        KIND,
        "Moves the angle up and down by 0.6°, once in two seconds, where 1° in all is allowed.",
        "CNV-1",
        fault=faults.ANGLE_CYCLES,
        size=radians(0.6),
    ),
    Mutation(
        "speed-six-rpm-off",
        KIND,
        "Keeps the speed 6 rpm too high, where k1 is 5 rpm.",
        "CNV-1",
        fault=faults.SPEED_BIASED,
        size=6.0 * RADIANS_PER_RPM,
    ),
    Mutation(
        "sum-cycles",
        KIND,
        "Accelerates and decelerates by 0.26 % of the torque, once a second, for which Σ|i| varies by more than k2.",
        "CNV-1",
        fault=faults.TORQUE_CYCLES,
        size=0.0026,
    ),
    Mutation(
        "rests-beside-the-optimum",
        KIND,
        "Rests 4° beside the angle that it has found.",
        "CNV-2",
        fault=faults.RESTS_BESIDE,
        size=radians(4.0),
    ),
    Mutation(
        "settles-in-seven-seconds",
        KIND,
        "Gives back 3° of angle 7.2 s after the start, where 6 s are allowed.",
        "CNV-1",
        fault=faults.SETTLES_LATE,
        size=7.2,
    ),
    Mutation(
        "limit-rounded-up",
        KIND,
        "Takes 26.03 A for the current limit of 26 A.",
        "CMD-1",
        factors=(("current_limit", 26.03 / 26.0),),
    ),
    Mutation(
        "power-a-billionth-off",
        KIND,
        "Estimates an input power that is 1.2e-9 too high, where 1e-9 is allowed.",
        "PWR-2",
        fault=faults.ESTIMATE_SCALED,
        size=1.0 + 1.2e-9,
    ),
)
"""Those of this kind."""
