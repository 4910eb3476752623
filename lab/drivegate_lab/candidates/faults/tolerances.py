"""Faults just beyond a tolerance, and correct controllers just within one, which no check may accuse.

Each correct controller is the reference with one alteration, made as those of the faulty controllers are.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from drivegate_lab.candidates.faults import oracle_sizes, sizes
from drivegate_lab.candidates.faults.mutation import Mutation, of_kind
from drivegate_lab.kernels.faults.current import state as faults

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


def _above_base(part: float) -> sizes.Size:
    """Make a speed by its share of the range from base speed to the highest."""
    return sizes.Size(
        lambda drive: sizes.BASE.of(drive) + part * (sizes.HIGHEST.of(drive) - sizes.BASE.of(drive)), "rpm"
    )


_BEGINS: Final = _above_base(0.04)
_ABOVE_BASE: Final = _above_base(0.05)

_ALL: Final = of_kind(
    "Near a limit",
    Mutation(
        "speed-offset",
        "Keeps the speed {size} too high, where k1 is {k1}.",
        fault=faults.SPEED_BIASED,
        size=sizes.share(0.7, sizes.K1),
    ),
    Mutation(
        "beside-the-optimum",
        "Rests {size} above the angle that it has found.",
        fault=faults.RESTS_BESIDE,
        size=oracle_sizes.NEAR_OPTIMUM,
    ),
    Mutation(
        "power-almost-a-billionth-off",
        "Estimates an input power that is 0.92e-9 too high, where 1e-9 is allowed.",
        fault=faults.ESTIMATE_SCALED,
        size=1.0 + 0.92e-9,
    ),
    Mutation(
        "advances-from-540-rpm",
        "Begins the advance at {begins}, where rated power is required from about {required}.",
        constants=(("advance_begins", _BEGINS),),
        numbers=(("begins", _BEGINS), ("required", _ABOVE_BASE)),
    ),
    Mutation(
        "gain-doubled",
        "Has twice the gain in its speed regulator, and so twice the answer to the noise of the measured speed.",
        factors=(("proportional", 2.0), ("integral_step", 2.0)),
    ),
    Mutation(
        "stops-early",
        "Takes k2 six times too large, and rests where the optimum is near.",
        factors=(("power_tolerance", 6.0),),
    ),
)

NEAR_DESIGNS: Final = MappingProxyType({mutation.name: mutation for mutation in _ALL})
"""Every one of them by its name."""
