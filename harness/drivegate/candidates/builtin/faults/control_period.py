"""Faults of what a control period is taken for, and of how much of it a step needs."""

from __future__ import annotations

from typing import Final

from drivegate.candidates.builtin.faults import sizes
from drivegate.candidates.builtin.faults.mutation import Mutation, of_kind
from drivegate_cases.documents.rounding import significant
from drivegate_models.faults.current import state as faults

FAULTS: Final = of_kind(
    "Control period",
    Mutation(
        "period-taken-for-100-microseconds",
        "Takes the control period for 100 µs, whatever the nameplate says.",
        "CNV-1",
        believes=(("control_period", 100e-6),),
    ),
    Mutation(
        "period-taken-for-1-millisecond",
        "Takes the control period for 1 ms, whatever the nameplate says: at 50 µs it decides every 5 ms.",
        "CNV-2",
        believes=(("control_period", 1e-3),),
        shown_by="a control period of 100 µs or less",
    ),
    Mutation(
        "derivative-of-50-microseconds",
        "Takes the change of the speed in a step for that in 50 µs, and so damps ten times too much at 500 µs.",
        "CNV-1",
        fault=faults.DIFFERENTIATED,
        size=50e-6,
        extent=sizes.share(1.0, sizes.INERTIA_CURRENT, digits=2),
    ),
    Mutation(
        "slewed-by-the-step",
        "Moves the current reference by {size} a step at most, ten times as fast at 50 µs as at 500 µs.",
        "CNV-1",
        fault=faults.SLEWED,
        size=sizes.Size(
            lambda drive: significant(0.000192 * sizes.CURRENT_LIMIT.of(drive) * sizes.PACE.of(drive), 2),
            "A",
        ),
    ),
    Mutation(
        "slow-step",
        "Divides 15,000 times in vain in every step.",
        "TIM-1",
        fault=faults.SLOW,
        size=15_000.0,
    ),
)
"""Those of this kind."""
