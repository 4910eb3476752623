"""Faults of the speed regulator, of the ranges of the commands, and of their derating against heat."""

from __future__ import annotations

from math import degrees, isinf, radians
from typing import Final

from drivegate_cases.documents.wording import significant
from drivegate_cases.drive.advance import advance_line
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import limits_of
from drivegate_lab.candidates.faults import sizes
from drivegate_lab.candidates.faults.mutation import Mutation, of_kind
from drivegate_lab.kernels.faults.current import state as faults

_AT_OVERSPEED: Final = 108.0
# At 500 µs eight times the time to converge, and a little.
_STEPS_UNDER_LOAD: Final = sizes.Size(
    lambda drive: significant(25.0 / 3.0 * sizes.SETTLING.of(drive) / sizes.CONTROL_PERIOD, 3)
)

DERATING_FAULTS: Final = of_kind(
    "Thermal derating",
    Mutation(
        "derates-after-a-minute",
        "Limits the current to a fifth of its limit after {size} under load, for good, although the load is rated.",
        "CNV-1",
        fault=faults.HEAT_KEPT,
        size=sizes.share(10.0, sizes.SETTLING),
        shown_by="a run of minutes",
    ),
    Mutation(
        "heat-never-leaves",
        "Adds up the time under load and lets nothing cool: after {size} the current is limited to a fifth for good.",
        "CNV-1",
        fault=faults.HEAT_KEPT,
        size=sizes.share(4.0 / 3.0, sizes.SETTLING),
    ),
    Mutation(
        "heat-counted-in-steps",
        "Counts {size} control periods under load for too hot, ten times as soon at 50 µs as at 500 µs.",
        "CNV-1",
        fault=faults.HEAT_IN_STEPS,
        size=_STEPS_UNDER_LOAD,
        shown_by="rated load with a control period of 50 µs, or for minutes",
    ),
    Mutation(
        "derating-chatters",
        "Limits the current after {size} under load and lets it go again, twice a second.",
        "CNV-1",
        fault=faults.DERATES_IN_TURNS,
        size=sizes.share(5.0, sizes.SETTLING),
        shown_by="a run of minutes",
    ),
    Mutation(
        "acceleration-trips",
        "Takes {size} at the current limit for a stalled shaft, and limits the current to a fifth for good.",
        "CNV-3",
        fault=faults.PEAK_TRIPS,
        size=sizes.share(1.09, sizes.MECHANICAL_TIME, digits=2),
    ),
)
"""Those of this kind."""
# Peak to peak three quarters of what is allowed of the torque, which has a ripple of its own.
_RIPPLE: Final = sizes.Size(
    lambda drive: significant(
        0.385 * min(limits_of(drive).closed_loop_ripple, 1.0) * drive.rating.current_limit_a, 2
    ),
    "A",
)


def _slope(drive: DriveDocument) -> float:
    start, _ = advance_line(drive)
    span = drive.rating.overspeed_rpm - drive.rating.base_speed_rpm
    return (_AT_OVERSPEED - round(degrees(start), 6)) / span


_SLOPE_TO_108_DEGREES: Final = sizes.Size(_slope, "° a rpm")

COMMAND_FAULTS: Final = of_kind(
    "Ranges of commands",
    Mutation(
        "advance-below-base",
        "Gives an advance angle of 1° below base speed.",
        "ADV-1",
        fault=faults.ADVANCES_BELOW_BASE,
        size=radians(1.0),
    ),
    Mutation(
        "advance-ends-late",
        "Ends the advance at {ends} on the way down, with its hysteresis on the wrong side of base speed.",
        "ADV-1",
        factors=(("base_speed", 0.99),),
        numbers=(("ends", sizes.share(0.99, sizes.BASE, digits=6)),),
    ),
    Mutation(
        "one-step-late",
        "Gives current reference and angle one control period late.",
        "ADV-1",
        fault=faults.DELAYED,
    ),
    Mutation(
        "angle-unclamped",
        "Adds {size} after the limits of the angle, wherever the error exceeds k1.",
        "ADV-2",
        fault=faults.BOOST_BEHIND_LIMITS,
        size=sizes.Size(lambda drive: 5.0 / sizes.K1.of(drive), "° a rpm of error"),
    ),
    Mutation(
        "slope-doubled",
        "Has too steep a line of initial angles, and no limit after it: 108° at {overspeed}.",
        "ADV-2",
        constants=(("angle_slope", _SLOPE_TO_108_DEGREES),),
        fault=faults.UNLIMITED_LINE,
    ),
    Mutation(
        "current-limit-exceeded",
        "Takes {taken} for the current limit of {current_limit}.",
        "CMD-1",
        factors=(("current_limit", 30.0 / 26.0),),
        numbers=(("taken", sizes.share(30.0 / 26.0, sizes.CURRENT_LIMIT)),),
    ),
    Mutation(
        "current-below-zero",
        "Requests a negative current to brake.",
        "CMD-1",
        fault=faults.REFERENCE_BELOW_ZERO,
    ),
)
"""Those of this kind."""


def _without_limit(drive: DriveDocument) -> str | None:
    return "the drive states no limit of its ripple" if isinf(limits_of(drive).closed_loop_ripple) else None


REGULATOR_FAULTS: Final = of_kind(
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
