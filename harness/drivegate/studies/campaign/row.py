"""What is kept of one run of a campaign: a row of numbers and words, made where the run is judged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

from drivegate.candidates.fault import Fault, bounded_line
from drivegate.checks.check import Check, Record, judged_elsewhere
from drivegate.checks.every_contract import DET_1
from drivegate.checks.margin import Margin
from drivegate.containment.messages import JudgedCandidate
from drivegate.contracts.catalogue import all_contracts, check_of, contract_of
from drivegate.drives.running import recorded
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import HarnessFault

PASS: Final = "pass"
FAIL: Final = "fail"
SET_ASIDE: Final = "set aside"
"""Verdict on a run that was not made, since no controller could do what it requires."""
NOT_JUDGED: Final = "not judged"
"""Verdict on a run to which none of the checks applies."""
HARNESS_FAULT: Final = "harness fault"
"""Verdict on a run in which the plant broke a rule that it guarantees."""
UNCOUNTED: Final = (SET_ASIDE, NOT_JUDGED, HARNESS_FAULT)
"""Verdicts on runs that say nothing about the candidate."""

JUDGED_CHECKS: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {
        contract.name: tuple(
            check.id
            for check in contract.checks
            if check.evaluate is not judged_elsewhere and not check.volatile and check is not DET_1
        )
        for contract in all_contracts()
    }
)
"""Checks of each contract that judge a run by itself, whatever the machine."""


@dataclass(frozen=True)
class RowRequest:
    """What a worker is to run."""

    scenario: Scenario
    checks: tuple[str, ...]


@dataclass(frozen=True)
class CampaignRow:
    """The outcome of a run."""

    verdict: str
    """`PASS`, `FAIL`, one of `UNCOUNTED`, or the kind of the candidate's fault."""
    message: str = ""
    """The fault in one line; empty without one."""
    margins: dict[str, float] | None = None
    """Margin of each check that applies."""
    measured: dict[str, str] | None = None
    """What each of them was measured as."""
    advisory: tuple[str, ...] = ()
    """Checks among them that only advise in this run."""
    observed: dict[str, float] | None = None
    """Values by the names in the contract's `observations`; empty of a run that did not come to its end."""


def run_row(loaded: JudgedCandidate, request: RowRequest) -> CampaignRow:
    if not contract_of(request.scenario.drive).is_fair(request.scenario):
        return CampaignRow(SET_ASIDE)
    try:
        record = recorded(loaded, request.scenario, loaded.controller())
        return _judged(record, request.checks)
    except HarnessFault as fault:
        return CampaignRow(HARNESS_FAULT, bounded_line(str(fault)))


def fault_row(fault: Fault) -> CampaignRow:
    return CampaignRow(fault.kind.value, bounded_line(fault.message))


def _judged(record: Record, checks: tuple[str, ...]) -> CampaignRow:
    judging = {name: check_of(record.scenario.drive.contract, name) for name in checks}
    margins: list[Margin] = []
    for check in judging.values():
        if check.reason_not_applicable(record.declaration, record.scenario.drive) is None:
            margin = check.evaluate(record)
            if margin is not None:
                margins.append(margin)
    return CampaignRow(
        _verdict(margins, judging),
        margins={margin.check: margin.value for margin in margins},
        measured={margin.check: margin.measured for margin in margins},
        advisory=tuple(margin.check for margin in margins if margin.advisory),
        observed=contract_of(record.scenario.drive).observe(record),
    )


def _verdict(margins: list[Margin], judging: Mapping[str, Check]) -> str:
    unmet = [judging[margin.check] for margin in margins if not margin.met and not margin.advisory]
    required = [check for check in unmet if check.level == "required"]
    if any(check.subject == "plant" for check in required):
        return HARNESS_FAULT
    if not margins:
        return NOT_JUDGED
    return FAIL if required else PASS
