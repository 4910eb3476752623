"""Faults of the speed regulator."""

from __future__ import annotations

from math import isinf
from typing import Final

from drivegate.candidates.builtin.faults import sizes
from drivegate.candidates.builtin.faults.mutation import Mutation, of_kind
from drivegate_cases.documents.wording import significant
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import limits_of
from drivegate_models.faults.current import state as faults

# Peak to peak three quarters of what is allowed of the torque, which has a ripple of its own.
_RIPPLE: Final = sizes.Size(
    lambda drive: significant(
        0.385 * min(limits_of(drive).closed_loop_ripple, 1.0) * drive.rating.current_limit_a, 2
    ),
    "A",
)


def _without_limit(drive: DriveDocument) -> str | None:
    return "the drive states no limit of its ripple" if isinf(limits_of(drive).closed_loop_ripple) else None


FAULTS: Final = of_kind(
    "Speed regulation",
    Mutation(
        "rippling-current",
        "Moves the current reference up and down by {size}, 250 times a second.",
        "RIP-3",
        fault=faults.RIPPLING,
        size=_RIPPLE,
        idle_because=_without_limit,
    ),
    Mutation(
        "chatters",
        "Begins and ends the advance at one speed, and takes {taken} for base speed.",
        "CNV-1",
        factors=(("base_speed", 1.1), ("advance_begins", 550.0 / 510.0)),
        numbers=(("taken", sizes.share(1.1, sizes.BASE, digits=6)),),
    ),
    Mutation(
        "no-anti-windup",
        "Lets the regulator's integral go on while the current reference is at its limit.",
        "CNV-3",
        fault=faults.NO_ANTI_WINDUP,
    ),
    Mutation(
        "no-integral",
        "Has no integral in its speed regulator.",
        "CPW-1",
        factors=(("integral_step", 0.0),),
    ),
    Mutation(
        "gain-tenfold",
        "Has ten times the gain in its speed regulator, and so amplifies the noise of the measured speed.",
        "ROB-2",
        factors=(("proportional", 10.0), ("integral_step", 10.0)),
    ),
)
"""Those of this kind."""
