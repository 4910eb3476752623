"""Faults of what protects windings and devices from heat."""

from __future__ import annotations

from typing import Final

from drivegate.candidates.builtin.faults import sizes
from drivegate.candidates.builtin.faults.mutation import Mutation, of_kind
from drivegate_cases.documents.rounding import significant
from drivegate_models.faults.current import state as faults

# At 500 µs eight times the time to converge, and a little.
_STEPS_UNDER_LOAD: Final = sizes.Size(
    lambda drive: significant(25.0 / 3.0 * sizes.SETTLING.of(drive) / sizes.CONTROL_PERIOD, 3)
)

FAULTS: Final = of_kind(
    "Thermal derating",
    Mutation(
        "derates-after-a-minute",
        "Limits the current to a fifth of its limit after {size} under load, for good, although the load is rated.",
        "CNV-1",
        fault=faults.HEAT_KEPT,
        size=sizes.share(10.0, sizes.SETTLING),
        shown_by="a run of minutes",
    ),
    Mutation(
        "heat-never-leaves",
        "Adds up the time under load and lets nothing cool: after {size} the current is limited to a fifth for good.",
        "CNV-1",
        fault=faults.HEAT_KEPT,
        size=sizes.share(4.0 / 3.0, sizes.SETTLING),
    ),
    Mutation(
        "heat-counted-in-steps",
        "Counts {size} control periods under load for too hot, ten times as soon at 50 µs as at 500 µs.",
        "CNV-1",
        fault=faults.HEAT_IN_STEPS,
        size=_STEPS_UNDER_LOAD,
        shown_by="rated load with a control period of 50 µs, or for minutes",
    ),
    Mutation(
        "derating-chatters",
        "Limits the current after {size} under load and lets it go again, twice a second.",
        "CNV-1",
        fault=faults.DERATES_IN_TURNS,
        size=sizes.share(5.0, sizes.SETTLING),
        shown_by="a run of minutes",
    ),
    Mutation(
        "acceleration-trips",
        "Takes {size} at the current limit for a stalled shaft, and limits the current to a fifth for good.",
        "CNV-3",
        fault=faults.PEAK_TRIPS,
        size=sizes.share(1.09, sizes.MECHANICAL_TIME, digits=2),
    ),
)
"""Those of this kind."""
