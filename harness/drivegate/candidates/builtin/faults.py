"""The faulty controllers: each a built-in one with one known fault, and the check that must catch it."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians
from types import MappingProxyType
from typing import Final, Literal

from drivegate_cases.documents.wording import nearest, one_line
from drivegate_models.errors import InputError
from drivegate_models.half_bridge.faults import state as faults
from drivegate_models.units import RADIANS_PER_RPM


@dataclass(frozen=True)
class Mutation:
    """One faulty controller.

    Attributes
    ----------
    name : str
        Its name; as a candidate it is named ``faulty:`` and this.
    sentence : str
        What is wrong with it.
    check : str
        Identifier of the check that must catch it.
    base : {"reference", "published"}
        The built-in controller that it is made from.
    factors : tuple of (str, float)
        Constants of `CONTROLLER_STATE` that are multiplied after every reset.
    fault : int
        What its steps do wrong, from `drivegate_models.half_bridge.faults.state`.
    size : float
        How large the fault is, in the units that the fault has.
    forgets : bool
        Whether a reset forgets what the run before has left; a controller that does not is faulty.
    """

    name: str
    sentence: str
    check: str
    base: Literal["reference", "published"] = "reference"
    factors: tuple[tuple[str, float], ...] = ()
    fault: int = faults.NO_FAULT
    size: float = 0.0
    forgets: bool = True


_ALL: Final = (
    Mutation(
        "power-one-percent-high",
        "Estimates an input power that is 1 % too high.",
        "PWR-2",
        fault=faults.ESTIMATE_SCALED,
        size=1.01,
    ),
    Mutation(
        "power-at-nominal-supply",
        "Estimates the input power with the nominal supply voltage instead of the measured one.",
        "PWR-2",
        fault=faults.ESTIMATE_AT_NOMINAL_SUPPLY,
    ),
    Mutation(
        "one-phase-left-out",
        "Leaves the last phase out of Σ|i|.",
        "PWR-2",
        fault=faults.SUM_WITHOUT_LAST_PHASE,
    ),
    Mutation(
        "sixteen-bit-overflow",
        "Keeps Σ|i| as a 16-bit number of milliamperes, which wraps around at 32.8 A.",
        "PWR-2",
        fault=faults.SUM_OVERFLOWS,
    ),
    Mutation(
        "advance-below-base",
        "Gives an advance angle of 1° below base speed.",
        "ADV-1",
        fault=faults.ADVANCES_BELOW_BASE,
        size=radians(1.0),
    ),
    Mutation(
        "advance-ends-late",
        "Ends the advance at 495 rpm on the way down, with its hysteresis on the wrong side of base speed.",
        "ADV-1",
        factors=(("base_speed", 0.99),),
    ),
    Mutation(
        "one-step-late",
        "Gives current reference and angle one control period late.",
        "ADV-1",
        fault=faults.DELAYED,
    ),
    Mutation(
        "angle-unclamped",
        "Adds 1° a rpm of speed error behind the limits of the angle, wherever the error exceeds k1.",
        "ADV-2",
        fault=faults.BOOST_BEHIND_LIMITS,
        size=radians(1.0) / RADIANS_PER_RPM,
    ),
    Mutation(
        "slope-doubled",
        "Has twice the slope in its line of initial angles, and no limit behind it: 108° at 2000 rpm.",
        "ADV-2",
        factors=(("angle_slope", 2.0),),
        fault=faults.UNLIMITED_LINE,
    ),
    Mutation(
        "current-limit-exceeded",
        "Takes 30 A for the current limit of 26 A.",
        "CMD-1",
        factors=(("current_limit", 30.0 / 26.0),),
    ),
    Mutation(
        "current-below-zero",
        "Requests a negative current to brake.",
        "CMD-1",
        fault=faults.REFERENCE_BELOW_ZERO,
    ),
    Mutation(
        "below-the-edge",
        "Keeps the angle at 51° or less, where 9.8 N·m at 1500 rpm are below the edge of what is feasible.",
        "RIP-1",
        fault=faults.ANGLE_CAPPED,
        size=radians(51.0),
    ),
    Mutation(
        "rippling-current",
        "Moves the current reference up and down by 2 A, 250 times a second.",
        "RIP-3",
        fault=faults.RIPPLING,
        size=2.0,
    ),
    Mutation(
        "hunts-for-ever",
        "Has no k2: the search goes on from the optimum and never rests.",
        "CNV-1",
        fault=faults.NEVER_RESTS,
    ),
    Mutation(
        "drifts",
        "Lets the angle that it has found move on by 0.5° a second.",
        "CNV-1",
        fault=faults.DRIFTS,
        size=radians(0.5),
    ),
    Mutation(
        "search-too-slow",
        "Decides every 2 s instead of every 100 ms.",
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
        "chatters",
        "Begins and ends the advance at one speed, and takes 550 rpm for base speed.",
        "CNV-1",
        factors=(("base_speed", 1.1), ("advance_begins", 550.0 / 510.0)),
    ),
    Mutation(
        "search-inverted",
        "Reverses the search where Σ|i| falls and goes on where it rises.",
        "CNV-2",
        fault=faults.SUM_MIRRORED,
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
        "Stays at its initial angle between 1230 and 1290 rpm, whatever the search says.",
        "CNV-2",
        fault=faults.BLIND_SPOT,
    ),
    Mutation(
        "stale-power",
        "Compares with the W of the old speed after a change of the speed reference.",
        "CNV-2",
        fault=faults.STALE_POWER,
    ),
    Mutation(
        "falling-load-ignored",
        "Starts the search anew when the load has risen, but not when it has fallen.",
        "CNV-2",
        fault=faults.FALLING_LOAD_IGNORED,
    ),
    Mutation(
        "never-rearms",
        "Holds the angle that it has found, whatever the load does afterwards.",
        "CNV-3",
        fault=faults.NEVER_REARMS,
    ),
    Mutation(
        "no-anti-windup",
        "Lets the regulator's integral go on while the current reference is at its limit.",
        "CNV-3",
        fault=faults.NO_ANTI_WINDUP,
    ),
    Mutation(
        "rpm-for-radians",
        "Takes the base speed's 500 rpm for rad/s, and so never advances.",
        "CPW-1",
        factors=(("base_speed", 1.0 / RADIANS_PER_RPM), ("advance_begins", 1.0 / RADIANS_PER_RPM)),
    ),
    Mutation(
        "no-integral",
        "Has no integral in its speed regulator.",
        "CPW-1",
        factors=(("integral_step", 0.0),),
    ),
    Mutation(
        "angle-capped",
        "Keeps the angle at 54° or less, which is enough up to 1500 rpm but not at 2000 rpm.",
        "CPW-2",
        fault=faults.ANGLE_CAPPED,
        size=radians(54.0),
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
        fault=faults.LINE_IS_LIMIT,
    ),
    Mutation(
        "saturation-ignored",
        "Does not notice that its current reference is at the limit, where a weaker machine needs more angle.",
        "ROB-1",
        fault=faults.SATURATION_IGNORED,
    ),
    Mutation(
        "only-without-noise",
        "Raises the angle by 3° whenever the measured supply differs from that of the step before.",
        "ROB-2",
        fault=faults.TRUSTS_SUPPLY,
        size=radians(3.0),
    ),
    Mutation(
        "gain-tenfold",
        "Has ten times the gain in its speed regulator, and so amplifies the noise of the measured speed.",
        "ROB-2",
        factors=(("proportional", 10.0), ("integral_step", 10.0)),
    ),
    Mutation(
        "latches-after-dropout",
        "Takes one reading of no speed for a standstill, and never advances again.",
        "ROB-3",
        fault=faults.LATCHES_AT_STANDSTILL,
    ),
    Mutation(
        "survives-reset",
        "Keeps the integral of the run before through a reset.",
        "DET-1",
        forgets=False,
    ),
    Mutation(
        "slow-step",
        "Divides 15,000 times in vain in every step.",
        "TIM-1",
        fault=faults.SLOW,
        size=15_000.0,
    ),
    Mutation(
        "flowchart-inverted",
        "Follows the flowchart, but reverses where W has fallen and goes on where it has risen.",
        "FLO-1",
        "published",
        fault=faults.SUM_MIRRORED,
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

MUTATIONS: Final = MappingProxyType({mutation.name: mutation for mutation in _ALL})
"""Every faulty controller by its name, in the order of the checks that must catch them."""


def find_mutation(name: str) -> Mutation:
    """Find a faulty controller."""
    if name not in MUTATIONS:
        raise InputError(
            f"the faulty controller '{one_line(name)}' is unknown, the nearest known one is "
            f"'{nearest(name, MUTATIONS)}'; known are {', '.join(MUTATIONS)}"
        )
    return MUTATIONS[name]
