"""Making the scenario of a sanitizer's report as simple as it can be had, like that of a check that fails."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from drivegate.candidates.fault import CandidateFault, Fault, FaultKind
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.drives.running import recorded
from drivegate.gate.shard import content_key
from drivegate.gate.shrinking import BUDGET, Trials, simplest_of
from drivegate.scenarios.title import titled
from drivegate_cases.documents.document import parse_document
from drivegate_cases.scenario.scenario import Scenario

_SHRUNK: Final = (FaultKind.SANITIZER, FaultKind.BUILDS)


@dataclass(frozen=True)
class FaultPlan:
    fault: Fault
    """A fault with the scenario in which it happened."""
    budget: int
    """Number of runs that may be spent."""


def shrinks(fault: Fault) -> bool:
    """Return True if it is worth while to look for a simpler scenario of a fault."""
    return fault.kind in _SHRUNK and fault.scenario is not None and fault.scenario.get("kind") != "script"


def fault_job(fault: Fault, effort: str) -> Job[Fault]:
    return Job(run_fault_shrink, FaultPlan(fault, BUDGET[effort]))


def run_fault_shrink(loaded: JudgedCandidate, plan: FaultPlan) -> Fault:
    """Make a scenario simpler for as long as the same line is reported; the same plan gives the same answer."""
    assert plan.fault.scenario is not None, "only a fault with a scenario is shrunk"
    scenario = parse_document(plan.fault.scenario, Scenario, "the scenario")
    simplest, fault = simplest_of(scenario, plan.fault, _Trials(loaded, plan, scenario))
    shown = scenario if simplest is scenario else titled(simplest)
    return replace(fault, scenario=shown.to_mapping())


class _Trials(Trials[Fault]):
    """Runs that end by one fault; that of the first scenario is known."""

    def __init__(self, loaded: JudgedCandidate, plan: FaultPlan, start: Scenario) -> None:
        super().__init__(loaded.candidate.declaration, start, plan.budget)
        self._loaded, self._fault = loaded, plan.fault
        self._known.add(content_key(start.to_mapping()))

    def _found(self, scenario: Scenario) -> Fault | None:
        try:
            # The process of the last instance has ended with it.
            recorded(self._loaded, scenario, self._loaded.controller())
        except CandidateFault as ended:
            return ended.fault if _is_same(ended.fault, self._fault) else None
        return None


def _is_same(fault: Fault, other: Fault) -> bool:
    """Return True if two faults are one; a sanitizer's differ by their place."""
    return (fault.kind, fault.error) == (other.kind, other.error)


def with_simplest_faults(faults: Sequence[Fault], shrunk: Mapping[int, Fault | None]) -> list[Fault]:
    """Put the simplest scenario of each fault in place of the first one."""
    return [shrunk.get(place) or fault for place, fault in enumerate(faults)]
