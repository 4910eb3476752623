"""The runs of known good controllers in one scenario, judged as the candidate is that is accused there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Final

from drivegate.candidates.declaration import NOTHING_DECLARED, Declaration
from drivegate.candidates.fault import CandidateFault
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import Record
from drivegate.checks.every_contract import TIM_1
from drivegate.checks.margin import Margin
from drivegate.containment.judge import own_candidate
from drivegate.containment.messages import JudgedCandidate
from drivegate.contracts.catalogue import check_of, contract_of
from drivegate.contracts.contract import Witness
from drivegate.drives.running import recorded
from drivegate.gate.plan import REPEATED
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.scenario import Scenario

UNWITNESSED: Final = (REPEATED, TIM_1.id)
"""Checks that no witness can speak on: of a repeated run, and of a target."""
# Checks that a candidate fails often fail in one scenario, whose run then serves them all.
_KEPT_RUNS: Final = 8


def witnesses_for(drive: DriveDocument) -> tuple[Witness, ...]:
    """Return the witnesses on a drive, in the order in which they are heard."""
    is_sensed = drive.position != "none"
    return tuple(
        witness
        for witness in contract_of(drive).witnesses
        if drive.kind in witness.kinds and witness.sensed is is_sensed
    )


def witnesses_on(check: str, drive: DriveDocument) -> tuple[Witness, ...]:
    return tuple(witness for witness in witnesses_for(drive) if witness.is_heard_on(check))


def _best_margin(witness: Witness, scenario: Scenario, declaration: Declaration, check: str) -> Margin | None:
    """Judge a witness by the declaration, or by the drive alone: it need not keep another one's promise."""
    judged_by = dict.fromkeys((declaration, replace(declaration, current_bandwidth=None)))
    records = (_record(witness, scenario, each) for each in judged_by)
    judge = check_of(scenario.drive.contract, check, declaration)
    margins = (judge.evaluate(record) for record in records if record is not None)
    return max(
        (margin for margin in margins if margin is not None), key=lambda each: each.value, default=None
    )


@lru_cache(maxsize=_KEPT_RUNS)
def _record(witness: Witness, scenario: Scenario, declaration: Declaration) -> Record | None:
    """Run a witness in a scenario; a fault of its own leaves it without a say."""
    judged = judged_witness(witness, scenario, declaration)
    try:
        return recorded(judged, scenario, judged.controller())
    except CandidateFault:
        return None


def judged_witness(witness: Witness, scenario: Scenario, declaration: Declaration) -> JudgedCandidate:
    """Return a witness as a candidate with the declaration of the one that is accused.

    No witness reads `enable`, so its bridge is on from the start. None follows a q current, but its torque.
    """
    declaration = replace(declaration.with_bridge_on(), references=NOTHING_DECLARED.references)
    if witness.made_for is None:
        return own_candidate(replace(resolve_candidate(witness.candidate), declaration=declaration))
    from drivegate.candidates.python.bridge import PythonController

    usual = resolve_candidate(contract_of(scenario.drive).usual_candidate)
    candidate = replace(usual, name=witness.candidate, declaration=declaration)
    made_for = witness.made_for
    return JudgedCandidate(candidate, lambda: PythonController(made_for(scenario)))


def met_by(
    check: str, scenario: Scenario, declaration: Declaration, first: Sequence[Witness] = ()
) -> tuple[Witness, Margin] | None:
    """Return a witness that meets a check in a scenario, and its margin, those that are likely to first.

    None where none does.
    """
    if check in UNWITNESSED:
        return None
    for witness in dict.fromkeys((*first, *witnesses_on(check, scenario.drive))):
        margin = _best_margin(witness, scenario, declaration, check)
        if margin is not None and margin.met:
            return witness, margin
    return None


def witness_that_meets(
    check: str, scenario: Scenario, declaration: Declaration, first: Sequence[Witness] = ()
) -> Witness | None:
    """Return a witness that meets a check in a scenario, as `met_by` finds it."""
    found = met_by(check, scenario, declaration, first)
    return None if found is None else found[0]
