"""Faults of what protects windings and devices from heat."""

from __future__ import annotations

from typing import Final

from drivegate.candidates.builtin.faults.mutation import Mutation
from drivegate_models.half_bridge.faults import state as faults

KIND: Final = "Thermal derating"

FAULTS: Final = (
    Mutation(
        "derates-after-a-minute",
        KIND,
        "Limits the current to a fifth of its limit after a minute under load, for good, although the load is rated.",
        "CNV-1",
        fault=faults.HEAT_KEPT,
        size=60.0,
        shown_by="a run of two minutes",
    ),
    Mutation(
        "heat-never-leaves",
        KIND,
        "Adds up the time under load and lets nothing cool: after 8 s the current is limited to a fifth for good.",
        "CNV-1",
        fault=faults.HEAT_KEPT,
        size=8.0,
    ),
    Mutation(
        "heat-counted-in-steps",
        KIND,
        "Counts 100,000 control periods under load for too hot, which are 50 s at 500 µs and 5 s at 50 µs.",
        "CNV-1",
        fault=faults.HEAT_IN_STEPS,
        size=1e5,
        shown_by="rated load with a control period of 50 µs, or for a minute",
    ),
    Mutation(
        "derating-chatters",
        KIND,
        "Limits the current after 30 s under load and lets it go again, twice a second.",
        "CNV-1",
        fault=faults.DERATES_IN_TURNS,
        size=30.0,
        shown_by="a run of two minutes",
    ),
    Mutation(
        "acceleration-trips",
        KIND,
        "Takes 0.1 s at the current limit for a stalled shaft, and limits the current to a fifth for good.",
        "CNV-3",
        fault=faults.PEAK_TRIPS,
        size=0.1,
    ),
)
"""Those of this kind."""
