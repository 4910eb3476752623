"""Faults of measured quantities: the estimate of the input power, filters, and single samples."""

from __future__ import annotations

from typing import Final

from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_lab.candidates.faults import sizes
from drivegate_lab.candidates.faults.mutation import Mutation, of_kind
from drivegate_lab.kernels.faults.current import state as faults

_HALF_WORD: Final = 32.768
FILTER_FAULTS: Final = of_kind(
    "Filters",
    Mutation(
        "speed-filter-too-slow",
        "Filters the speed over {time}, and regulates what comes out.",
        "CNV-1",
        fault=faults.SPEED_FILTERED,
        size=sizes.share(0.002, sizes.PACE),
        numbers=(("time", sizes.per_pace(250.0, "ms")),),
    ),
    Mutation(
        "filter-for-50-microseconds",
        "Filters the speed with the coefficient that {time} need at 50 µs, ten times too slow at 500 µs.",
        "CNV-1",
        fault=faults.SPEED_FILTERED,
        size=sizes.share(0.005, sizes.PACE),
        numbers=(("time", sizes.per_pace(10.0, "ms")),),
    ),
    Mutation(
        "base-speed-filtered",
        "Ends the advance by a filtered speed, which comes below base speed later than the speed of the step.",
        "ADV-1",
        fault=faults.BASE_SPEED_FILTERED,
        size=0.02,
    ),
    Mutation(
        "filter-sticks",
        "Filters the speed in whole numbers, which a difference below {size} does not move.",
        "CNV-1",
        fault=faults.SPEED_FILTER_STICKS,
        size=sizes.share(1.6, sizes.K1),
    ),
    Mutation(
        "estimate-filtered",
        "Gives an estimate of the input power that has passed a filter of 10 ms.",
        "PWR-2",
        fault=faults.ESTIMATE_FILTERED,
        size=0.05,
    ),
    Mutation(
        "supply-filtered",
        "Estimates the input power with the supply voltage of a filter of 50 ms.",
        "PWR-2",
        fault=faults.SUPPLY_FILTERED,
        size=0.01,
    ),
    Mutation(
        "sum-filtered",
        "Filters Σ|i| over {time}, so that each decision compares what earlier angles have cost.",
        "CNV-1",
        fault=faults.SUM_FILTERED,
        size=sizes.share(0.0002, sizes.PACE),
        numbers=(("time", sizes.per_pace(2.5, "s")),),
    ),
)
"""Those of this kind."""
SAMPLE_FAULTS: Final = of_kind(
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


def _never_overflows(drive: DriveDocument) -> str | None:
    """State why 16 bits of milliamperes hold every current sum of a drive."""
    greatest = drive.machine.phases * (drive.rating.current_limit_a + drive.inverter.hysteresis_band_a)
    if greatest >= _HALF_WORD:
        return None
    return (
        f"Σ|i| is no more than {greatest:.3g} A with all phases at the current limit, and 16 bits hold that"
    )


POWER_ESTIMATE_FAULTS: Final = of_kind(
    "Power estimate",
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
        idle_because=_never_overflows,
    ),
)
"""Those of this kind."""
