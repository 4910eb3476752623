"""Faults of what outlives a run."""

from __future__ import annotations

from typing import Final

from drivegate_lab.candidates.faults.mutation import Mutation, of_kind
from drivegate_lab.kernels.faults.current import state as faults

_SEARCH: Final = (
    "offset",
    "step",
    "direction",
    "old_power",
    "mode",
    "forbidden",
    "held_power",
    "speed_reference",
    "good_offset",
    "good_integral",
    "good_power",
)

FAULTS: Final = of_kind(
    "Instances and resets",
    Mutation(
        "survives-reset",
        "Keeps the integral of the run before through a reset.",
        "DET-1",
        keeps=("integral",),
    ),
    Mutation(
        "reset-keeps-the-search",
        "Keeps what its search has found through a reset.",
        "DET-1",
        keeps=_SEARCH,
    ),
    Mutation(
        "instances-share-the-integral",
        "Keeps the regulator's integral in a variable that all instances share and no reset clears.",
        "DET-1",
        keeps=("integral",),
        shares=True,
    ),
    Mutation(
        "learns-across-runs",
        "Begins its search at the offset of the run before.",
        "DET-1",
        fault=faults.LEARNS,
        keeps=("memory",),
    ),
    Mutation(
        "filter-not-started-anew",
        "Filters the speed, and after a reset from where the run before has left the filter.",
        "DET-1",
        fault=faults.SPEED_FILTERED,
        size=0.3,
        keeps=("memory", "latched"),
    ),
    Mutation(
        "searches-in-seven-runs",
        "Counts its runs in three bits: from the eighth run of an instance on it searches nothing.",
        "CNV-2",
        fault=faults.RUNS_COUNTED,
        size=8.0,
        keeps=("tally",),
        shown_by="an instance that is used again",
    ),
)
"""Those of this kind."""
