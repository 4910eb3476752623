"""Faults of the estimate of the input power."""

from __future__ import annotations

from typing import Final

from drivegate.candidates.builtin.faults.mutation import Mutation
from drivegate_models.half_bridge.faults import state as faults

KIND: Final = "Power estimate"

FAULTS: Final = (
    Mutation(
        "power-one-percent-high",
        KIND,
        "Estimates an input power that is 1 % too high.",
        "PWR-2",
        fault=faults.ESTIMATE_SCALED,
        size=1.01,
    ),
    Mutation(
        "power-at-nominal-supply",
        KIND,
        "Estimates the input power with the nominal supply voltage instead of the measured one.",
        "PWR-2",
        fault=faults.ESTIMATE_AT_NOMINAL_SUPPLY,
    ),
    Mutation(
        "one-phase-left-out",
        KIND,
        "Leaves the last phase out of Σ|i|.",
        "PWR-2",
        fault=faults.SUM_WITHOUT_LAST_PHASE,
    ),
    Mutation(
        "sixteen-bit-overflow",
        KIND,
        "Keeps Σ|i| as a 16-bit number of milliamperes, which wraps around at 32.8 A.",
        "PWR-2",
        fault=faults.SUM_OVERFLOWS,
    ),
)
"""Those of this kind."""
