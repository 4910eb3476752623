"""Faults of clocks, counters and whole numbers."""

from __future__ import annotations

from math import radians
from typing import Final

from drivegate.candidates.builtin.faults.mutation import Mutation
from drivegate_models.half_bridge.faults import state as faults
from drivegate_models.units import RADIANS_PER_RPM

KIND: Final = "Clocks and whole numbers"

FAULTS: Final = (
    Mutation(
        "tick-counter-overflows",
        KIND,
        "Counts control periods in 16 bits, and starts its search anew where the count wraps around, after 16.4 s.",
        "CNV-3",
        fault=faults.STEPS_OVERFLOW,
        size=2.0**15,
    ),
    Mutation(
        "milliseconds-overflow",
        KIND,
        "Keeps milliseconds in 16 bits, and starts its search anew where they wrap around, after 32.8 s.",
        "CNV-1",
        fault=faults.MILLISECONDS_OVERFLOW,
        size=2.0**15,
        shown_by="a run of two minutes",
    ),
    Mutation(
        "timer-always-due",
        KIND,
        "Keeps the time of its next decision in 16 bits of milliseconds, and so decides at every step after 65.5 s.",
        "CNV-1",
        fault=faults.ALWAYS_DUE,
        size=65.536,
        shown_by="a run of two minutes, or a start at a later time",
    ),
    Mutation(
        "catches-up-with-the-clock",
        KIND,
        "Counts its decisions from time zero, and makes up for those missed where its clock starts later.",
        "CNV-1",
        fault=faults.CATCHES_UP,
        shown_by="a start at a later time than zero",
    ),
    Mutation(
        "integral-cut-off",
        KIND,
        "Keeps the regulator's integral in steps of 0.02 A and cuts off what is less: a small error never adds up.",
        "CNV-1",
        fault=faults.INTEGRAL_IN_STEPS,
        size=0.02,
    ),
    Mutation(
        "integral-of-eight-bits",
        KIND,
        "Keeps the regulator's integral with eight fractional bits, too few for what a short control period adds.",
        "CNV-1",
        fault=faults.INTEGRAL_IN_STEPS,
        size=2.0**-8,
        shown_by="a control period of 100 µs or less",
    ),
    Mutation(
        "speed-in-ten-rpm",
        KIND,
        "Keeps the speed in whole 10 rpm.",
        "CNV-1",
        fault=faults.SPEED_IN_STEPS,
        size=10.0 * RADIANS_PER_RPM,
    ),
    Mutation(
        "speed-error-overflows",
        KIND,
        "Keeps the speed error as a 16-bit number of hundredths of a rpm, which wraps around at 327.68 rpm.",
        "CNV-3",
        fault=faults.ERROR_OVERFLOWS,
        size=327.68 * RADIANS_PER_RPM,
    ),
    Mutation(
        "power-sum-overflows",
        KIND,
        "Adds Σ|i| up in 24 bits of milliamperes, enough for 200 steps of 500 µs between two decisions and no more.",
        "CNV-2",
        fault=faults.POWER_SUM_OVERFLOWS,
        size=2.0**24 / 1000.0,
        shown_by="a control period of 100 µs or less",
    ),
    Mutation(
        "step-count-in-a-byte",
        KIND,
        "Counts the steps from one decision to the next in a byte, which 200 of 500 µs fit into and no more.",
        "CNV-2",
        fault=faults.COUNT_OVERFLOWS,
        size=256.0,
        shown_by="a control period of 390 µs or less",
    ),
    Mutation(
        "angle-of-six-bits",
        KIND,
        "Keeps the angle in 64 steps a turn, each of 5.6°, cut off.",
        "CNV-2",
        fault=faults.ANGLE_IN_STEPS,
        size=radians(360.0 / 64.0),
    ),
    Mutation(
        "twenty-restarts",
        KIND,
        "Counts how often its search has started anew, and gives it up for the initial angle after twenty times.",
        "CNV-2",
        fault=faults.REARMS_COUNTED,
        size=20.0,
        shown_by="twenty disturbances in a row",
    ),
)
"""Those of this kind."""
