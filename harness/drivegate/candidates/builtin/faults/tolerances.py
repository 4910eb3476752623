"""Faults just beyond a tolerance; `near` has their counterparts just within it."""

from __future__ import annotations

from typing import Final

from drivegate.candidates.builtin.faults import oracle_sizes, sizes
from drivegate.candidates.builtin.faults.mutation import Mutation, of_kind
from drivegate_models.faults.current import state as faults

FAULTS: Final = of_kind(
    "Just beyond a tolerance",
    Mutation(
        "angle-cycles",
        "Moves the angle up and down by {size}, once in two seconds, where {angle_tolerance} in all is allowed.",
        "CNV-1",
        fault=faults.ANGLE_CYCLES,
        size=sizes.share(0.6, sizes.ANGLE_TOLERANCE),
    ),
    Mutation(
        "speed-six-rpm-off",
        "Keeps the speed {size} too high, where k1 is {k1}.",
        "CNV-1",
        fault=faults.SPEED_BIASED,
        size=sizes.share(1.2, sizes.K1),
    ),
    Mutation(
        "sum-cycles",
        "Accelerates and decelerates by {percent} % of the torque, once a second, so that Σ|i| varies by more than k2.",
        "CNV-1",
        fault=faults.TORQUE_CYCLES,
        size=sizes.share(0.52, sizes.K2),
        numbers=(("percent", sizes.share(52.0, sizes.K2)),),
    ),
    Mutation(
        "rests-beside-the-optimum",
        "Settles {size} off the angle that it has found.",
        "CNV-2",
        fault=faults.RESTS_BESIDE,
        size=oracle_sizes.ABOVE_OPTIMUM,
    ),
    Mutation(
        "settles-in-seven-seconds",
        "Gives back {extent} of angle {size} after the start, where {settling} are allowed.",
        "CNV-1",
        fault=faults.SETTLES_LATE,
        size=sizes.share(1.2, sizes.SETTLING),
        extent=sizes.share(3.0, sizes.ANGLE_TOLERANCE),
    ),
    Mutation(
        "limit-rounded-up",
        "Takes {taken} for the current limit of {current_limit}.",
        "CMD-1",
        factors=(("current_limit", 26.03 / 26.0),),
        numbers=(("taken", sizes.share(26.03 / 26.0, sizes.CURRENT_LIMIT, digits=6)),),
    ),
    Mutation(
        "power-a-billionth-off",
        "Estimates an input power that is 1.2e-9 too high, where 1e-9 is allowed.",
        "PWR-2",
        fault=faults.ESTIMATE_SCALED,
        size=1.0 + 1.2e-9,
    ),
)
"""Those of this kind."""
