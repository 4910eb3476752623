"""Faults of following the published flowchart."""

from __future__ import annotations

from typing import Final

from drivegate.candidates.builtin.faults import sizes
from drivegate.candidates.builtin.faults.mutation import Mutation, of_kind
from drivegate_models.faults.current import state as faults

FAULTS: Final = of_kind(
    "Flowchart",
    Mutation(
        "flowchart-inverted",
        "Follows the flowchart, but reverses where W has fallen and goes on where it has risen.",
        "FLO-1",
        "published",
        fault=faults.SUM_MIRRORED,
        size=sizes.share(200.0 / 130.0, sizes.ALL_PHASES),
    ),
    Mutation(
        "flowchart-twice-as-often",
        "Follows the flowchart, but decides twice in its declared period.",
        "FLO-1",
        "published",
        factors=(("decision_steps", 0.5),),
    ),
    Mutation(
        "flowchart-without-k1",
        "Follows the flowchart, but goes on while the speed is off by more than k1.",
        "FLO-1",
        "published",
        factors=(("speed_tolerance", 1e6),),
    ),
    Mutation(
        "flowchart-without-k2",
        "Follows the flowchart, but moves the angle however little W has changed.",
        "FLO-1",
        "published",
        factors=(("power_tolerance", 0.0),),
    ),
)
"""Those of this kind."""
