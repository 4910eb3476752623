"""Check of the phase currents' peaks."""

from __future__ import annotations

from drivegate.check import Check
from drivegate.margin import Margin
from drivegate.run_record import RunRecord
from drivegate_models import ledger


def peak_current(record: RunRecord) -> Margin:
    """Judge the greatest phase current, overshoot through the diodes included.

    Parameters
    ----------
    record : RunRecord
        The run.

    Returns
    -------
    Margin
        Distance from the limit plus the band, over that sum.
    """
    motor = record.scenario.motor
    allowed = motor.current_limit_a + motor.hysteresis_band_a
    peak = float(record.run.totals[ledger.PEAK])
    # The band's edge itself is met to rounding.
    return Margin("CUR-1", 1.0 - peak / (allowed * (1.0 + 1e-12)), f"{peak:.5g} A")


CUR_1 = Check(
    "CUR-1",
    "No phase current exceeds the limit plus the hysteresis band, diode overshoot included.",
    "P3",
    "candidate",
    "advisory",
    "26 A + band",
    "every run",
    peak_current,
)
