"""Faults of the search for the advance angle: its initial angle, its steps, and the published flowchart."""

from __future__ import annotations

from typing import Final

from drivegate_lab.candidates.faults import oracle_sizes, sizes
from drivegate_lab.candidates.faults.mutation import Mutation, of_kind
from drivegate_lab.kernels.faults.current import state as faults
from drivegate_models.units import RADIANS_PER_RPM

ANGLE_MODEL_FAULTS: Final = of_kind(
    "Model of the angle",
    Mutation(
        "below-the-edge",
        "Keeps the angle at {size} or less, where the required point is below the edge of what is feasible.",
        "RIP-1",
        fault=faults.ANGLE_CAPPED,
        size=oracle_sizes.BELOW_POINT,
        idle_because=oracle_sizes.no_angle_below_point,
    ),
    Mutation(
        "rpm-for-radians",
        "Takes the base speed's {base} for rad/s, and so never advances.",
        "CPW-1",
        factors=(("base_speed", 1.0 / RADIANS_PER_RPM), ("advance_begins", 1.0 / RADIANS_PER_RPM)),
    ),
    Mutation(
        "angle-capped",
        "Keeps the angle at {size} or less, which is enough up to {highest} but not up to {overspeed}.",
        "CPW-2",
        fault=faults.ANGLE_CAPPED,
        size=oracle_sizes.ENOUGH_TO_HIGHEST,
        idle_because=oracle_sizes.no_more_angle_beyond,
    ),
    Mutation(
        "nominal-table",
        "Takes its angle from a table made for nominal R, L and k_e, and searches nothing.",
        "ROB-1",
        fault=faults.NOMINAL_TABLE,
    ),
    Mutation(
        "line-is-the-limit",
        "Never raises the angle beyond the initial one, which a weaker machine needs.",
        "ROB-1",
        constants=oracle_sizes.line_of_nominal_machine(),
        fault=faults.LINE_IS_LIMIT,
    ),
    Mutation(
        "saturation-ignored",
        "Does not notice that its current reference is at the limit, where a weaker machine needs more angle.",
        "ROB-1",
        constants=oracle_sizes.line_of_nominal_machine(),
        fault=faults.SATURATION_IGNORED,
    ),
)
"""Those of this kind."""
SEARCH_FAULTS: Final = of_kind(
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
FLOWCHART_FAULTS: Final = of_kind(
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
