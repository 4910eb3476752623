"""Faults of filters."""

from __future__ import annotations

from typing import Final

from drivegate.candidates.builtin.faults import sizes
from drivegate.candidates.builtin.faults.mutation import Mutation, of_kind
from drivegate_models.faults.current import state as faults

FAULTS: Final = of_kind(
    "Filters",
    Mutation(
        "speed-filter-too-slow",
        "Filters the speed over {time}, and regulates what comes out.",
        "CNV-1",
        fault=faults.SPEED_FILTERED,
        size=sizes.share(0.002, sizes.PACE),
        numbers=(("time", sizes.per_pace(250.0, "ms")),),
    ),
    Mutation(
        "filter-for-50-microseconds",
        "Filters the speed with the coefficient that {time} need at 50 µs, ten times too slow at 500 µs.",
        "CNV-1",
        fault=faults.SPEED_FILTERED,
        size=sizes.share(0.005, sizes.PACE),
        numbers=(("time", sizes.per_pace(10.0, "ms")),),
    ),
    Mutation(
        "base-speed-filtered",
        "Ends the advance by a filtered speed, which comes below base speed later than the speed of the step.",
        "ADV-1",
        fault=faults.BASE_SPEED_FILTERED,
        size=0.02,
    ),
    Mutation(
        "filter-sticks",
        "Filters the speed in whole numbers, which a difference below {size} does not move.",
        "CNV-1",
        fault=faults.SPEED_FILTER_STICKS,
        size=sizes.share(1.6, sizes.K1),
    ),
    Mutation(
        "estimate-filtered",
        "Gives an estimate of the input power that has passed a filter of 10 ms.",
        "PWR-2",
        fault=faults.ESTIMATE_FILTERED,
        size=0.05,
    ),
    Mutation(
        "supply-filtered",
        "Estimates the input power with the supply voltage of a filter of 50 ms.",
        "PWR-2",
        fault=faults.SUPPLY_FILTERED,
        size=0.01,
    ),
    Mutation(
        "sum-filtered",
        "Filters Σ|i| over {time}, so that each decision compares what earlier angles have cost.",
        "CNV-1",
        fault=faults.SUM_FILTERED,
        size=sizes.share(0.0002, sizes.PACE),
        numbers=(("time", sizes.per_pace(2.5, "s")),),
    ),
)
"""Those of this kind."""
