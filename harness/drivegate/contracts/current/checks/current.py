"""Check of the phase currents' peaks."""

from __future__ import annotations

from drivegate.candidates.declaration import Declaration
from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, at_most
from drivegate.contracts.current.record import CurrentRecord
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_models.machine import ledger

ROUNDING = 1e-12
"""Relative rounding of a current that reaches the band's edge (1)."""


def peak_current(record: CurrentRecord) -> Margin:
    """Judge the greatest phase current, overshoot through the diodes included."""
    drive = record.scenario.drive
    # The band's edge itself is met to rounding.
    allowed = (drive.rating.current_limit_a + drive.inverter.hysteresis_band_a) * (1.0 + ROUNDING)
    peak = float(record.run.totals[ledger.PEAK])
    return Margin("CUR-1", at_most(peak, allowed), f"{peak:.5g} A")


def _unless_regulated(_declaration: Declaration, drive: DriveDocument) -> str | None:
    regulation = drive.inverter.regulation
    if regulation in (None, "every-half"):
        return None
    return f'with regulation = "{regulation}" not every half window is regulated, so no reference bounds a current'


CUR_1 = Check(
    id="CUR-1",
    every_run=True,
    requirement="No phase current exceeds the limit plus the hysteresis band, diode overshoot included.",
    source="P3",
    level="advisory",
    limit="{current} + band",
    scenarios="every run",
    formula="1 - greatest phase current / ({current} + band)",
    why="Devices and magnets are chosen for that current; where EMF exceeds the supply, the diodes can drive more.",
    evaluate=peak_current,
    reason_not_applicable=_unless_regulated,
)
