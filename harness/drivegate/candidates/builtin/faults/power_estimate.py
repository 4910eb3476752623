"""Faults of the estimate of the input power."""

from __future__ import annotations

from typing import Final

from drivegate.candidates.builtin.faults.mutation import Mutation, of_kind
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_models.faults.current import state as faults

_HALF_WORD: Final = 32.768


def _never_overflows(drive: DriveDocument) -> str | None:
    """State why 16 bits of milliamperes hold every current sum of a drive."""
    greatest = drive.machine.phases * (drive.rating.current_limit_a + drive.inverter.hysteresis_band_a)
    if greatest >= _HALF_WORD:
        return None
    return (
        f"Σ|i| is no more than {greatest:.3g} A with all phases at the current limit, and 16 bits hold that"
    )


FAULTS: Final = of_kind(
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
