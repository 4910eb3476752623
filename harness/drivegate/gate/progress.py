"""What the runs of a check have come to so far, and when it must end."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Any, Final, Literal

from drivegate.candidates.fault import Fault, FaultKind
from drivegate.checks.check import InfeasibleScenario, JudgedRun, ShardOutcome
from drivegate.gate.focus import Focus
from drivegate.gate.plan import Origin, Work
from drivegate.results.document import CheckSection

_GRACE_SECONDS: Final = 2.0
"""How long work that has begun may go on after the time has run out."""


@dataclass
class Progress:
    """What the runs have come to so far."""

    deadline: float | None
    """Time of the monotonic clock after which no more work begins (s)."""
    focus: Focus
    counting: frozenset[str]
    """Checks that can fail the candidate."""
    runs: dict[Origin, list[JudgedRun]] = field(default_factory=lambda: {origin: [] for origin in Origin})
    faults: list[Fault] = field(default_factory=list)
    infeasible: list[InfeasibleScenario] = field(default_factory=list)
    complete: bool = True
    """Whether all planned runs were made."""
    stopped: bool = False
    """Whether the first failure ended the check."""
    incomplete: Literal["interrupted", "max time"] | None = None
    """As in `drivegate.results.document.ResultDocument`."""
    outcomes: tuple[CheckSection, ...] = ()
    traces: tuple[dict[str, list[float]], ...] = ()
    behaviour: dict[str, Any] | None = None
    """What the runs were judged as, and what reports show of them; empty before all runs were made."""

    def is_overdue(self) -> bool:
        """Return True if work that has begun must end."""
        return self.deadline is not None and time.monotonic() > self.deadline + _GRACE_SECONDS

    def end(self) -> None:
        """Note that work was ended; if it was not for the time, for a request."""
        if not self.cuts_short():
            self.incomplete = "interrupted"

    def add(self, work: Work, outcome: ShardOutcome | Fault) -> None:
        if isinstance(outcome, Fault):
            self.add_fault(outcome)
        else:
            self.runs[work.origin].extend(outcome.runs)
            self.infeasible.extend(outcome.infeasible)

    def add_fault(self, fault: object) -> None:
        """Add what a job ended with if that is a fault, and not known yet."""
        known = [_what_happened(fault) for fault in self.faults]
        if isinstance(fault, Fault) and _what_happened(fault) not in known:
            self.faults.append(fault)

    @property
    def all_runs(self) -> list[JudgedRun]:
        """All runs, in the order in which they are judged."""
        return [run for origin in Origin for run in self.runs[origin]]

    @property
    def stops_here(self) -> bool:
        """Whether a failure ends the check."""
        if not self.focus.stop_at_first:
            return False
        return bool(self.faults) or self.focus.broken_by(self.all_runs, self.counting)

    def cuts_short(self) -> bool:
        """Return True if no more work may begin; called where there is some, so that the check is incomplete then."""
        if self.incomplete is None and self.deadline is not None and time.monotonic() > self.deadline:
            self.incomplete = "max time"
        return self.incomplete is not None


def _what_happened(fault: Fault) -> tuple[str, str]:
    """Return what is the same of two faults that are one; a sanitizer's message has values, its place has none."""
    return fault.kind, fault.error if fault.kind is FaultKind.SANITIZER else fault.message
