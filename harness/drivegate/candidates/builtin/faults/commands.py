"""Faults of the ranges of the commands."""

from __future__ import annotations

from math import radians
from typing import Final

from drivegate.candidates.builtin.faults.mutation import Mutation
from drivegate_models.half_bridge.faults import state as faults
from drivegate_models.units import RADIANS_PER_RPM

KIND: Final = "Ranges of commands"

FAULTS: Final = (
    Mutation(
        "advance-below-base",
        KIND,
        "Gives an advance angle of 1° below base speed.",
        "ADV-1",
        fault=faults.ADVANCES_BELOW_BASE,
        size=radians(1.0),
    ),
    Mutation(
        "advance-ends-late",
        KIND,
        "Ends the advance at 495 rpm on the way down, with its hysteresis on the wrong side of base speed.",
        "ADV-1",
        factors=(("base_speed", 0.99),),
    ),
    Mutation(
        "one-step-late",
        KIND,
        "Gives current reference and angle one control period late.",
        "ADV-1",
        fault=faults.DELAYED,
    ),
    Mutation(
        "angle-unclamped",
        KIND,
        "Adds 1° a rpm of speed error behind the limits of the angle, wherever the error exceeds k1.",
        "ADV-2",
        fault=faults.BOOST_BEHIND_LIMITS,
        size=radians(1.0) / RADIANS_PER_RPM,
    ),
    Mutation(
        "slope-doubled",
        KIND,
        "Has twice the slope in its line of initial angles, and no limit behind it: 108° at 2000 rpm.",
        "ADV-2",
        factors=(("angle_slope", 2.0),),
        fault=faults.UNLIMITED_LINE,
    ),
    Mutation(
        "current-limit-exceeded",
        KIND,
        "Takes 30 A for the current limit of 26 A.",
        "CMD-1",
        factors=(("current_limit", 30.0 / 26.0),),
    ),
    Mutation(
        "current-below-zero",
        KIND,
        "Requests a negative current to brake.",
        "CMD-1",
        fault=faults.REFERENCE_BELOW_ZERO,
    ),
)
"""Those of this kind."""
