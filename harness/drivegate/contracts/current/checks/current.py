"""Checks of the phase currents: their peaks, and that what flows into a star flows out of it."""

from __future__ import annotations

import numpy as np

from drivegate.candidates.declaration import Declaration
from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, Moment, at_most
from drivegate.contracts.current.checks.shown import around
from drivegate.contracts.current.record import CurrentRecord
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_models.machine import ledger

ROUNDING = 1e-12
"""Relative rounding of a current that reaches the band's edge (1)."""
NEUTRAL_TOLERANCE = 1e-9
"""Greatest share of the currents, and of the exchanged energy, that may be missing (1)."""


def peak_current(record: CurrentRecord) -> Margin:
    drive = record.scenario.drive
    # The band's edge itself is met to rounding.
    allowed = (drive.rating.current_limit_a + drive.inverter.hysteresis_band_a) * (1.0 + ROUNDING)
    peak = float(record.run.totals[ledger.PEAK])
    return Margin("CUR-1", at_most(peak, allowed), f"{peak:.5g} A")


def peak_moment(record: CurrentRecord) -> Moment | None:
    """Show the greatest phase current of each control period around the greatest of all."""
    trace, drive = record.run.trace, record.scenario.drive
    if not len(trace):
        return None
    peaks = trace["current_peak_a"]
    place = int(np.argmax(peaks))
    allowed = drive.rating.current_limit_a + drive.inverter.hysteresis_band_a
    quantity, words = "greatest phase current (A)", f"{peaks[place]:.5g} A"
    levels = ((f"limit {allowed:.4g} A", allowed),)
    return around(trace["time_s"], place, [("greatest phase current", peaks)], quantity, levels, words)


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
    moment=peak_moment,
    reason_not_applicable=_unless_regulated,
)


def isolated_neutral(record: CurrentRecord) -> Margin | None:
    if record.scenario.drive.has_split_supply:
        return None
    observed = record.run.observed
    worst = max(observed.neutral_current, observed.unequal_halves)
    measured = f"Σ i {observed.neutral_current:.1e} of Σ|i|, halves apart by {observed.unequal_halves:.1e}"
    return Margin("NEU-1", at_most(worst, NEUTRAL_TOLERANCE), measured)


def _unless_isolated(_declaration: Declaration, drive: DriveDocument) -> str | None:
    if drive.has_split_supply:
        return "the phases of this drive are decoupled: each has its own return to the tap of the supply"
    return None


NEU_1 = Check(
    id="NEU-1",
    every_run=True,
    requirement=(
        "The phase currents of a star sum to zero, and both halves of its link give the same charge in every control "
        "period."
    ),
    source="Kirchhoff's law",
    subject="plant",
    limit="1e-9 relative in every control period",
    scenarios="every run of a drive with an isolated neutral",
    formula="1 - greatest of |Σ i| / Σ|i| and |energy of upper half - of lower half| / exchanged / 1e-9",
    why="Who conducts in a star follows from this law alone. It is drivegate's own obligation, not the candidate's.",
    evaluate=isolated_neutral,
    reason_not_applicable=_unless_isolated,
)
