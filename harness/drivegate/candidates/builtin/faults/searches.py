"""Faults of the search for the advance angle."""

from __future__ import annotations

from typing import Final

from drivegate.candidates.builtin.faults import sizes
from drivegate.candidates.builtin.faults.mutation import Mutation, of_kind
from drivegate_models.faults.current import state as faults

FAULTS: Final = of_kind(
    "Search",
    Mutation(
        "hunts-for-ever",
        "Has no k2: the search goes on from the optimum and never rests.",
        "CNV-1",
        fault=faults.NEVER_RESTS,
    ),
    Mutation(
        "drifts",
        "Lets the angle that it has found move on by {size} a second.",
        "CNV-1",
        fault=faults.DRIFTS,
        size=sizes.share(0.5, sizes.ANGLE_TOLERANCE),
    ),
    Mutation(
        "search-too-slow",
        "Decides twenty times less often than every {decision_period}.",
        "CNV-1",
        factors=(("decision_steps", 20.0),),
    ),
    Mutation(
        "no-walk-back",
        "Does not take back a step of the search that has cost the torque.",
        "CNV-1",
        fault=faults.NO_WALK_BACK,
    ),
    Mutation(
        "search-inverted",
        "Reverses the search where Σ|i| falls and goes on where it rises.",
        "CNV-2",
        fault=faults.SUM_MIRRORED,
        size=sizes.share(200.0 / 130.0, sizes.ALL_PHASES),
    ),
    Mutation(
        "signed-sum",
        "Adds the phase currents without taking their magnitudes.",
        "CNV-2",
        fault=faults.SUM_WITHOUT_MAGNITUDES,
    ),
    Mutation(
        "stops-too-early",
        "Takes k2 fifty times too large and rests at the first small change.",
        "CNV-2",
        factors=(("power_tolerance", 50.0),),
    ),
    Mutation(
        "blind-spot",
        "Stays at its initial angle between {first} and {last}, whatever the search says.",
        "CNV-2",
        fault=faults.BLIND_SPOT,
        region=(sizes.in_range(0.76, -3.0), sizes.in_range(0.76, 3.0)),
    ),
    Mutation(
        "stale-power",
        "Compares with the W of the old speed after a change of the speed reference.",
        "CNV-2",
        fault=faults.STALE_POWER,
    ),
    Mutation(
        "falling-load-ignored",
        "Restarts the search when the load has risen, but not when it has fallen.",
        "CNV-2",
        fault=faults.FALLING_LOAD_IGNORED,
    ),
    Mutation(
        "never-rearms",
        "Holds the angle that it has found, whatever the load does afterwards.",
        "CNV-3",
        fault=faults.NEVER_REARMS,
    ),
)
"""Those of this kind."""
