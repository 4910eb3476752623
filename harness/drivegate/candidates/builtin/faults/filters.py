"""Faults of filters."""

from __future__ import annotations

from typing import Final

from drivegate.candidates.builtin.faults.mutation import Mutation
from drivegate_models.half_bridge.faults import state as faults
from drivegate_models.units import RADIANS_PER_RPM

KIND: Final = "Filters"

FAULTS: Final = (
    Mutation(
        "speed-filter-too-slow",
        KIND,
        "Filters the speed over 250 ms, and regulates what comes out.",
        "CNV-1",
        fault=faults.SPEED_FILTERED,
        size=0.002,
    ),
    Mutation(
        "filter-for-50-microseconds",
        KIND,
        "Filters the speed with the coefficient that 10 ms need at 50 µs, which are 100 ms at 500 µs.",
        "CNV-1",
        fault=faults.SPEED_FILTERED,
        size=0.005,
    ),
    Mutation(
        "base-speed-filtered",
        KIND,
        "Ends the advance by a filtered speed, which comes below base speed later than the speed of the step.",
        "ADV-1",
        fault=faults.BASE_SPEED_FILTERED,
        size=0.02,
    ),
    Mutation(
        "filter-sticks",
        KIND,
        "Filters the speed in whole numbers, which a difference below 8 rpm does not move.",
        "CNV-1",
        fault=faults.SPEED_FILTER_STICKS,
        size=8.0 * RADIANS_PER_RPM,
    ),
    Mutation(
        "estimate-filtered",
        KIND,
        "Gives an estimate of the input power that has passed a filter of 10 ms.",
        "PWR-2",
        fault=faults.ESTIMATE_FILTERED,
        size=0.05,
    ),
    Mutation(
        "supply-filtered",
        KIND,
        "Estimates the input power with the supply voltage of a filter of 50 ms.",
        "PWR-2",
        fault=faults.SUPPLY_FILTERED,
        size=0.01,
    ),
    Mutation(
        "sum-filtered",
        KIND,
        "Filters Σ|i| over 2.5 s, so that each decision compares what earlier angles have cost.",
        "CNV-1",
        fault=faults.SUM_FILTERED,
        size=0.0002,
    ),
)
"""Those of this kind."""
