"""The kernels that a wheel carries: those that a first check of any candidate may use."""

from __future__ import annotations

from drivegate.candidates.declaration import NOTHING_DECLARED
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import own_candidate
from drivegate.contracts.catalogue import contract_of
from drivegate.drives.envelope_document import envelope_of
from drivegate.drives.kinds import DRIVE_KINDS
from drivegate.drives.running import recorded
from drivegate.gate.warm_up import compile_missing
from drivegate.gate.witnesses import witnesses_for
from drivegate_cases.drive.drive_document import load_drive


def compile_for_first_check() -> list[tuple[str, str]]:
    """Compile the kernels of all kinds of drives, of their envelopes and of their witnesses.

    Returns candidate and drive of checks whose pages use the remaining kernels.
    """
    drives = [load_drive(kind.default_drive) for kind in DRIVE_KINDS.values()]
    compile_missing(drives)
    for drive in drives:
        envelope_of(drive)
        scenario = contract_of(drive).fixed_scenarios(drive, NOTHING_DECLARED)[1]
        usual = contract_of(drive).usual_candidate
        named = [witness.candidate for witness in witnesses_for(drive) if witness.made_for is None]
        for name in dict.fromkeys((usual, *named)):
            loaded = own_candidate(resolve_candidate(name))
            recorded(loaded, scenario, loaded.controller())
    return [(contract_of(drive).usual_candidate, drive.name) for drive in drives]
