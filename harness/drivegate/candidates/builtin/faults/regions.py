"""Faults that show in a small region of speeds, loads or supplies alone."""

from __future__ import annotations

from math import radians
from typing import Final

from drivegate.candidates.builtin.faults.mutation import Mutation
from drivegate_models.half_bridge.faults import state as faults
from drivegate_models.units import RADIANS_PER_RPM

KIND: Final = "Rare regions"

FAULTS: Final = (
    Mutation(
        "corner-without-limit",
        KIND,
        "Has no limit of the angle from 1170 to 1190 rpm at light load, once its search holds: 95°.",
        "ADV-2",
        fault=faults.CORNER_WITHOUT_LIMIT,
        size=radians(95.0),
        shown_by="1180 rpm with little load",
    ),
    Mutation(
        "wrong-row",
        KIND,
        "Has one wrong row in its table of least angles: 66° at 1340 rpm.",
        "CNV-2",
        fault=faults.WRONG_ROW,
        size=radians(66.0),
        shown_by="1340 rpm",
    ),
    Mutation(
        "current-floor",
        KIND,
        "Requests 6 A or more above 1400 rpm, however light the load.",
        "CNV-1",
        fault=faults.REFERENCE_FLOOR,
        size=6.0,
        shown_by="the lightest loads at high speed",
    ),
    Mutation(
        "swell-trips",
        KIND,
        "Takes a supply of more than 108.5 % for a fault, and limits the current to a fifth for good.",
        "CNV-3",
        fault=faults.SWELL_TRIPS,
        size=1.085,
        shown_by="a supply of 109 %",
    ),
    Mutation(
        "overspeed-capped",
        KIND,
        "Takes a speed reference above 1900 rpm for 1900 rpm.",
        "CPW-2",
        fault=faults.SPEED_CAPPED,
        size=1900.0 * RADIANS_PER_RPM,
        shown_by="more than 1900 rpm",
    ),
    Mutation(
        "standstill-latches",
        KIND,
        "Takes a speed reference of zero for the end of all work, and never advances again.",
        "CNV-3",
        fault=faults.STOP_LATCHES,
        shown_by="a speed reference of zero, and up again",
    ),
)
"""Those of this kind."""
