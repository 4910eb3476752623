"""Faults of the initial angle and of what it is taken from."""

from __future__ import annotations

from typing import Final

from drivegate.candidates.builtin.faults import oracle_sizes
from drivegate.candidates.builtin.faults.mutation import Mutation, of_kind
from drivegate_models.faults.current import state as faults
from drivegate_models.units import RADIANS_PER_RPM

FAULTS: Final = of_kind(
    "Model of the angle",
    Mutation(
        "below-the-edge",
        "Keeps the angle at {size} or less, where the required point is below the edge of what is feasible.",
        "RIP-1",
        fault=faults.ANGLE_CAPPED,
        size=oracle_sizes.BELOW_POINT,
        idle_because=oracle_sizes.no_angle_below_point,
    ),
    Mutation(
        "rpm-for-radians",
        "Takes the base speed's {base} for rad/s, and so never advances.",
        "CPW-1",
        factors=(("base_speed", 1.0 / RADIANS_PER_RPM), ("advance_begins", 1.0 / RADIANS_PER_RPM)),
    ),
    Mutation(
        "angle-capped",
        "Keeps the angle at {size} or less, which is enough up to {highest} but not up to {overspeed}.",
        "CPW-2",
        fault=faults.ANGLE_CAPPED,
        size=oracle_sizes.ENOUGH_TO_HIGHEST,
        idle_because=oracle_sizes.no_more_angle_beyond,
    ),
    Mutation(
        "nominal-table",
        "Takes its angle from a table made for nominal R, L and k_e, and searches nothing.",
        "ROB-1",
        fault=faults.NOMINAL_TABLE,
    ),
    Mutation(
        "line-is-the-limit",
        "Never raises the angle beyond the initial one, which a weaker machine needs.",
        "ROB-1",
        constants=oracle_sizes.line_of_nominal_machine(),
        fault=faults.LINE_IS_LIMIT,
    ),
    Mutation(
        "saturation-ignored",
        "Does not notice that its current reference is at the limit, where a weaker machine needs more angle.",
        "ROB-1",
        constants=oracle_sizes.line_of_nominal_machine(),
        fault=faults.SATURATION_IGNORED,
    ),
)
"""Those of this kind."""
