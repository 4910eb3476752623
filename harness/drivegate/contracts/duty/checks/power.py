"""The plant's own check: every control period's energy goes somewhere, in the circuit and on the shaft."""

from __future__ import annotations

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, at_most
from drivegate.contracts.duty.record import DutyRecord
from drivegate_models.machine.shaft_ledger import shaft_error

TOLERANCE = 1e-9
"""Greatest energy that a control period may miss, over its throughput (1)."""


def balanced_energy(record: DutyRecord) -> Margin:
    circuit, shaft = record.run.worst_balance, shaft_error(record.run.shaft)
    missed = max(circuit, shaft)
    measured = f"{circuit:.1e} of the throughput, on the shaft {shaft:.1e}" if missed else "exact"
    return Margin("PWR-1", at_most(missed, TOLERANCE), measured)


DUTY_PWR_1 = Check(
    id="PWR-1",
    every_run=True,
    requirement=(
        "In every control period the energy from the dc link equals copper, core and device loss, shaft work and the "
        "change of what the windings store; on a link with a capacitor the source's energy equals what it loses in "
        "its resistance, chopper, core, bridge and the change of the capacitor's. On the shaft the "
        "machine's work equals that of load and friction and the "
        "change of kinetic energy, nothing that opposes the rotation drives it, and a weight takes m g h."
    ),
    subject="plant",
    limit="1e-9 of the throughput in every control period",
    scenarios="every run",
    formula=(
        "1 - greatest |link - copper - core - devices - shaft - stored| / throughput / 1e-9; a throughput counts as "
        "1e-6 of what the link and the current limit exchange in the period at least, below which rounding is all "
        "there is; likewise 1 - greatest |machine - load - friction - lifted - kinetic| / throughput / 1e-9"
    ),
    why="Every comparison of losses rests on it. It is drivegate's own obligation, not the candidate's.",
    evaluate=balanced_energy,
)
