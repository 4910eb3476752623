"""Faults that show in a small region of speeds, loads or supplies alone."""

from __future__ import annotations

from math import degrees, radians
from typing import Final

from drivegate.candidates.builtin.faults import sizes
from drivegate.candidates.builtin.faults.mutation import Mutation, of_kind
from drivegate_cases.drive.advance import advance_line
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_models.faults.current import state as faults

_ROW: Final = 0.84
_ABOVE_THE_LINE: Final = 12.0
_MOST: Final = 90.0


def _far_above_the_line(drive: DriveDocument) -> float:
    """Return an angle that is 12° above the recommended line at the speed of the wrong row, or the greatest (deg)."""
    start, slope = advance_line(drive)
    speed = sizes.in_range(_ROW).number(drive) - sizes.BASE.number(drive)
    return min(round(degrees(start + slope * speed) + _ABOVE_THE_LINE, 1), _MOST)


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
        "standstill-latches",
        "Takes a speed reference of zero for the end of all work, and never advances again.",
        "CNV-3",
        fault=faults.STOP_LATCHES,
        shown_by="a speed reference of zero, and up again",
    ),
)
"""Those of this kind."""
