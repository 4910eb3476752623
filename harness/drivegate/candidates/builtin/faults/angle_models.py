"""Faults of the initial angle and of what it is taken from."""

from __future__ import annotations

from math import radians
from typing import Final

from drivegate.candidates.builtin.faults.mutation import Mutation
from drivegate_models.half_bridge.faults import state as faults
from drivegate_models.units import RADIANS_PER_RPM

KIND: Final = "Model of the angle"

FAULTS: Final = (
    Mutation(
        "below-the-edge",
        KIND,
        "Keeps the angle at 51° or less, where 9.8 N·m at 1500 rpm are below the edge of what is feasible.",
        "RIP-1",
        fault=faults.ANGLE_CAPPED,
        size=radians(51.0),
    ),
    Mutation(
        "rpm-for-radians",
        KIND,
        "Takes the base speed's 500 rpm for rad/s, and so never advances.",
        "CPW-1",
        factors=(("base_speed", 1.0 / RADIANS_PER_RPM), ("advance_begins", 1.0 / RADIANS_PER_RPM)),
    ),
    Mutation(
        "angle-capped",
        KIND,
        "Keeps the angle at 54° or less, which is enough up to 1500 rpm but not at 2000 rpm.",
        "CPW-2",
        fault=faults.ANGLE_CAPPED,
        size=radians(54.0),
    ),
    Mutation(
        "nominal-table",
        KIND,
        "Takes its angle from a table made for nominal R, L and k_e, and searches nothing.",
        "ROB-1",
        fault=faults.NOMINAL_TABLE,
    ),
    Mutation(
        "line-is-the-limit",
        KIND,
        "Never raises the angle beyond the initial one, which a weaker machine needs.",
        "ROB-1",
        fault=faults.LINE_IS_LIMIT,
    ),
    Mutation(
        "saturation-ignored",
        KIND,
        "Does not notice that its current reference is at the limit, where a weaker machine needs more angle.",
        "ROB-1",
        fault=faults.SATURATION_IGNORED,
    ),
)
"""Those of this kind."""
