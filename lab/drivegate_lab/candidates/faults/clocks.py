"""Faults of clocks, counters and whole numbers, and of the control period."""

from __future__ import annotations

from math import radians
from typing import Final

from drivegate_cases.documents.wording import significant
from drivegate_lab.candidates.faults import sizes
from drivegate_lab.candidates.faults.mutation import Mutation, of_kind
from drivegate_lab.kernels.faults.current import state as faults

# A milliampere on the drive of the paper, where 200 steps lie between two decisions and 104 A flow at most.
_MILLIAMPERES: Final = sizes.Size(
    lambda drive: significant(sizes.CONDUCTED.of(drive) / 104.0 / sizes.PACE.of(drive), 3)
)
_SUM_OF_24_BITS: Final = sizes.Size(lambda drive: 2.0**24 * _MILLIAMPERES.of(drive) / 1000.0, "A")

CLOCK_FAULTS: Final = of_kind(
    "Clocks and whole numbers",
    Mutation(
        "tick-counter-overflows",
        "Counts control periods in 16 bits, and restarts its search where the count wraps around, after 16.4 s.",
        "CNV-3",
        fault=faults.STEPS_OVERFLOW,
        size=2.0**15,
    ),
    Mutation(
        "milliseconds-overflow",
        "Keeps milliseconds in 16 bits, and restarts its search where they wrap around, after 32.8 s.",
        "CNV-1",
        fault=faults.MILLISECONDS_OVERFLOW,
        size=2.0**15,
        shown_by="a run of two minutes",
    ),
    Mutation(
        "timer-always-due",
        "Keeps the time of its next decision in 16 bits of milliseconds, and so decides at every step after 65.5 s.",
        "CNV-2",
        fault=faults.ALWAYS_DUE,
        size=65.536,
        shown_by="a load that changes after more than a minute, or a start at a later time",
    ),
    Mutation(
        "catches-up-with-the-clock",
        "Counts its decisions from time zero, and makes up for those missed where its clock starts later.",
        "CNV-1",
        fault=faults.CATCHES_UP,
        shown_by="a start at a later time than zero",
    ),
    Mutation(
        "integral-cut-off",
        "Keeps the regulator's integral in steps of {size} and cuts off what is less: a small error never adds up.",
        "CNV-1",
        fault=faults.INTEGRAL_IN_STEPS,
        size=sizes.share(1.73, sizes.INTEGRAL_OF_K1, digits=2),
    ),
    Mutation(
        "integral-of-eight-bits",
        "Keeps the regulator's integral in binary steps of {size}, too few for what a short control period adds.",
        "CNV-1",
        fault=faults.INTEGRAL_IN_STEPS,
        size=sizes.power_of_two(sizes.share(0.2, sizes.INTEGRAL_OF_K1)),
        shown_by="a control period of 100 µs or less",
    ),
    Mutation(
        "speed-in-ten-rpm",
        "Keeps the speed in whole {size}.",
        "CNV-1",
        fault=faults.SPEED_IN_STEPS,
        size=sizes.share(2.0, sizes.K1),
    ),
    Mutation(
        "speed-error-overflows",
        "Keeps the speed error as a 16-bit number of five-hundredths of k1, which wraps around at {size}.",
        "CNV-3",
        fault=faults.ERROR_OVERFLOWS,
        size=sizes.share(2.0**15 / 500.0, sizes.K1, digits=9),
    ),
    Mutation(
        "power-sum-overflows",
        "Adds Σ|i| up in 24 bits, up to {size}: enough for steps of 500 µs between two decisions and no more.",
        "CNV-2",
        fault=faults.POWER_SUM_OVERFLOWS,
        size=_SUM_OF_24_BITS,
        shown_by="a control period of 100 µs or less",
    ),
    Mutation(
        "step-count-in-a-byte",
        "Counts the steps from one decision to the next, {decision_period}, in a byte, which 256 steps overflow.",
        "CNV-2",
        fault=faults.COUNT_OVERFLOWS,
        size=256.0,
        shown_by="a control period of less than a 256th of {decision_period}",
    ),
    Mutation(
        "angle-of-six-bits",
        "Keeps the angle in 64 steps a turn, each of 5.6°, cut off.",
        "CNV-2",
        fault=faults.ANGLE_IN_STEPS,
        size=radians(360.0 / 64.0),
    ),
    Mutation(
        "twenty-restarts",
        "Counts how often its search has restarted, and gives it up for the initial angle after twenty times.",
        "CNV-2",
        fault=faults.REARMS_COUNTED,
        size=20.0,
        shown_by="twenty disturbances in a row",
    ),
)
"""Those of this kind."""
CONTROL_PERIOD_FAULTS: Final = of_kind(
    "Control period",
    Mutation(
        "period-taken-for-100-microseconds",
        "Takes the control period for 100 µs, whatever the nameplate says.",
        "CNV-1",
        believes=(("control_period", 100e-6),),
    ),
    Mutation(
        "period-taken-for-1-millisecond",
        "Takes the control period for 1 ms, whatever the nameplate says: at 50 µs it decides every 5 ms.",
        "CNV-2",
        believes=(("control_period", 1e-3),),
        shown_by="a control period of 100 µs or less",
    ),
    Mutation(
        "derivative-of-50-microseconds",
        "Takes the change of the speed in a step for that in 50 µs, and so damps ten times too much at 500 µs.",
        "CNV-1",
        fault=faults.DIFFERENTIATED,
        size=50e-6,
        extent=sizes.share(1.0, sizes.INERTIA_CURRENT, digits=2),
    ),
    Mutation(
        "slewed-by-the-step",
        "Moves the current reference by {size} a step at most, ten times as fast at 50 µs as at 500 µs.",
        "CNV-1",
        fault=faults.SLEWED,
        size=sizes.Size(
            lambda drive: significant(0.000192 * sizes.CURRENT_LIMIT.of(drive) * sizes.PACE.of(drive), 2),
            "A",
        ),
    ),
    Mutation(
        "slow-step",
        "Divides 15,000 times in vain in every step.",
        "TIM-1",
        fault=faults.SLOW,
        size=15_000.0,
    ),
)
"""Those of this kind."""
