"""Faults that show in a small region of speeds, loads or supplies alone."""

from __future__ import annotations

from math import degrees, radians
from typing import Final

from drivegate_cases.documents.wording import significant
from drivegate_cases.drive.advance import advance_line
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_lab.candidates.faults import sizes
from drivegate_lab.candidates.faults.mutation import Mutation, of_kind
from drivegate_lab.kernels.faults.current import state as faults

_ROW: Final = 0.84
_ABOVE_THE_LINE: Final = 12.0
_MOST: Final = 90.0


def _far_above_the_line(drive: DriveDocument) -> float:
    """Return an angle that is 12° above the recommended line at the speed of the wrong row, or the greatest (deg)."""
    start, slope = advance_line(drive)
    speed = sizes.in_range(_ROW).number(drive) - sizes.BASE.number(drive)
    return min(round(degrees(start + slope * speed) + _ABOVE_THE_LINE, 1), _MOST)


# At the pace of the reference of the paper's drive 50 ms.
_MOMENT: Final = sizes.Size(lambda drive: sizes.per_pace(0.05).of(drive), "s")


def _creep(drive: DriveDocument) -> float:
    """Return a rate of the speed reference at which the time to converge is not enough for any step (rpm/s)."""
    return significant(0.5 * sizes.K1.of(drive) / sizes.SETTLING.of(drive), 2)


FAULTS: Final = of_kind(
    "Rare regions",
    Mutation(
        "corner-without-limit",
        "Has no limit of the angle from {first} to {last} at light load, once its search holds: 95°.",
        "ADV-2",
        fault=faults.CORNER_WITHOUT_LIMIT,
        size=radians(95.0),
        extent=sizes.share(0.384, sizes.RATED_SUM, digits=6),
        region=(sizes.in_range(0.68, -1.0), sizes.in_range(0.68, 1.0)),
        numbers=(("middle", sizes.in_range(0.68)),),
        shown_by="{middle} with little load",
    ),
    Mutation(
        "wrong-row",
        "Has one wrong row in its table of least angles: {size} at {middle}.",
        "CNV-2",
        fault=faults.WRONG_ROW,
        size=sizes.Size(_far_above_the_line, "°"),
        region=(sizes.in_range(_ROW, -0.5), sizes.in_range(_ROW, 0.5)),
        numbers=(("middle", sizes.in_range(_ROW)),),
        shown_by="{middle}",
    ),
    Mutation(
        "current-floor",
        "Requests {size} or more above {first}, however light the load.",
        "CNV-1",
        fault=faults.REFERENCE_FLOOR,
        size=sizes.share(0.23, sizes.CURRENT_LIMIT, digits=2),
        region=(sizes.in_range(0.9),),
        shown_by="the lightest loads at high speed",
    ),
    Mutation(
        "swell-trips",
        "Takes a supply of more than 108.5 % for a fault, and limits the current to a fifth for good.",
        "CNV-3",
        fault=faults.SWELL_TRIPS,
        size=1.085,
        shown_by="a supply of 109 %",
    ),
    Mutation(
        "overspeed-capped",
        "Takes a speed reference above {size} for {size}.",
        "CPW-2",
        fault=faults.SPEED_CAPPED,
        size=sizes.beyond_range(0.8),
        shown_by="more than {size}",
    ),
    Mutation(
        "reference-ramped-beyond",
        "Lets its speed reference change slowly above {highest}: by {rate} a second.",
        "CPW-2",
        fault=faults.BEYOND_RAMPED,
        size=sizes.Size(lambda drive: _creep(drive) * sizes.CONTROL_PERIOD, "rpm"),
        extent=sizes.HIGHEST,
        numbers=(("rate", sizes.Size(_creep, "rpm")),),
        shown_by="a step of the speed reference above {highest}",
    ),
    Mutation(
        "step-beyond-trips",
        "Takes a change of its speed reference above {highest} for a runaway, and limits the current to a fifth.",
        "CPW-2",
        fault=faults.BEYOND_TRIPS,
        size=sizes.HIGHEST,
        shown_by="a step of the speed reference above {highest}",
    ),
    Mutation(
        "idling-trips",
        "Takes {size} without a load for the end of all work, and limits the current to a fifth for good.",
        "CNV-3",
        fault=faults.IDLE_TRIPS,
        size=_MOMENT,
        shown_by="a load that vanishes and comes back",
    ),
    Mutation(
        "idling-ends-advance",
        "Ends the advance for good where the load is gone for {size}.",
        "CNV-2",
        fault=faults.IDLE_LATCHES,
        size=_MOMENT,
        shown_by="a load that vanishes and comes back",
    ),
    Mutation(
        "lift-trips",
        "Takes a shaft that leaves its reference faster than it ever came to it for a broken coupling, and limits the "
        "current to a fifth for good.",
        "ROB-3",
        fault=faults.BREAKING_AWAY_TRIPS,
        size=1.1,
        shown_by="a wheel that is lifted from the ground and set down",
    ),
    Mutation(
        "standstill-latches",
        "Takes a speed reference of zero for the end of all work, and never advances again.",
        "CNV-3",
        fault=faults.STOP_LATCHES,
        shown_by="a speed reference of zero, and up again",
    ),
)
"""Those of this kind."""
