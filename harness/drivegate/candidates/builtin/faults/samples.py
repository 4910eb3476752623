"""Faults that a single sample brings out."""

from __future__ import annotations

from typing import Final

from drivegate.candidates.builtin.faults import sizes
from drivegate.candidates.builtin.faults.mutation import Mutation, of_kind
from drivegate_models.faults.current import state as faults

FAULTS: Final = of_kind(
    "Single samples",
    Mutation(
        "only-without-noise",
        "Raises the angle by {size} whenever the measured supply differs from that of the step before.",
        "ROB-2",
        fault=faults.TRUSTS_SUPPLY,
        size=sizes.share(3.0, sizes.ANGLE_TOLERANCE),
    ),
    Mutation(
        "latches-after-dropout",
        "Takes one reading of no speed for a standstill, and never advances again.",
        "ROB-3",
        fault=faults.LATCHES_AT_STANDSTILL,
    ),
    Mutation(
        "lost-current-trips",
        "Takes one sample without any current for an open circuit, and does not advance any more.",
        "ROB-3",
        fault=faults.LOST_CURRENT_TRIPS,
        size=sizes.share(0.077, sizes.CURRENT_LIMIT, digits=2),
        extent=sizes.share(0.000385, sizes.CURRENT_LIMIT, digits=2),
        shown_by="currents that are lost",
    ),
    Mutation(
        "overspeed-by-one-sample",
        "Takes one speed of 105 % of the reference for overspeed, and limits the current to a fifth for good.",
        "ROB-3",
        fault=faults.OVERSPEED_TRIPS,
        size=1.05,
        shown_by="a false encoder edge",
    ),
    Mutation(
        "lowest-supply-kept",
        "Takes the supply for the lowest that was ever seen.",
        "PWR-2",
        fault=faults.LOWEST_SUPPLY_KEPT,
        shown_by="a dip of the supply, or noise",
    ),
    Mutation(
        "lost-speeds-add-up",
        "Counts samples without any speed, and limits the current to a fifth after 60 of them in all.",
        "ROB-3",
        fault=faults.LOST_SPEEDS_COUNTED,
        size=60.0,
        shown_by="twenty disturbances in a row",
    ),
    Mutation(
        "one-phase-for-five",
        "Searches by {phases} times the magnitude of the first phase's current.",
        "CNV-2",
        fault=faults.ONE_PHASE_FOR_ALL,
        numbers=(("phases", sizes.PHASES),),
    ),
)
"""Those of this kind."""
