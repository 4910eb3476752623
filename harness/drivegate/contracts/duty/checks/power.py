"""The plant's own check: every control period's energy goes somewhere."""

from __future__ import annotations

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, at_most
from drivegate.contracts.duty.record import DutyRecord

TOLERANCE = 1e-9
"""Greatest energy that a control period may miss, over its throughput (1)."""


def balanced_energy(record: DutyRecord) -> Margin:
    missed = record.run.worst_balance
    return Margin(
        "PWR-1", at_most(missed, TOLERANCE), f"{missed:.1e} of the throughput" if missed else "exact"
    )


DUTY_PWR_1 = Check(
    id="PWR-1",
    every_run=True,
    requirement=(
        "In every control period the energy from the dc link equals copper, core and device loss, shaft work and the "
        "change of what the windings store."
    ),
    subject="plant",
    limit="1e-9 of the throughput in every control period",
    scenarios="every run",
    formula=(
        "1 - greatest |link - copper - core - devices - shaft - stored| / throughput / 1e-9; a throughput counts as "
        "1e-6 of what the link and the current limit exchange in the period at least, below which rounding is all "
        "there is"
    ),
    why="Every comparison of losses rests on it. It is drivegate's own obligation, not the candidate's.",
    evaluate=balanced_energy,
)
