"""The same scenario once more in another process: what `DET-1` cannot tell from within one (a process id, say)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

from drivegate.candidates.fault import Fault
from drivegate.checks.judging import JudgedRun
from drivegate.checks.margin import Margin
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.containment.pool import WorkerPool
from drivegate.drives.running import recorded
from drivegate.gate.plan import REPEATED
from drivegate_cases.documents.document import parse_document
from drivegate_cases.scenario.scenario import Scenario

DIFFERENT: Final = Margin(REPEATED, -1.0, "the repetition in another process differs")
"""What a check of repetitions comes to where another process answers differently."""


def repetition_job(scenario: Scenario) -> Job[int]:
    """Plan to run a scenario in a process that has done nothing before."""
    return Job(run_repetition, scenario, afresh=True)


def run_repetition(loaded: JudgedCandidate, scenario: Scenario) -> int:
    """Run a scenario; this is what the worker process does."""
    return recorded(loaded, scenario, loaded.controller()).run.digest


def repeated_elsewhere(pool: WorkerPool, runs: Sequence[JudgedRun]) -> Iterator[JudgedRun | Fault]:
    """Repeat those runs in other processes whose repetitions have been the same so far."""
    repeated = [run for run in runs if _repeats_itself(run)]
    digests = pool.map([repetition_job(_scenario_of(run)) for run in repeated])
    for run in runs:
        digest = next(digests) if _repeats_itself(run) else run.digest
        if isinstance(digest, Fault):
            yield digest
        yield run if isinstance(digest, Fault) or digest == run.digest else _corrected(run)


def _repeats_itself(run: JudgedRun) -> bool:
    return any(margin.check == REPEATED and margin.met for margin in run.margins)


def _scenario_of(run: JudgedRun) -> Scenario:
    return parse_document(run.scenario, Scenario, "a scenario of the check")


def _corrected(run: JudgedRun) -> JudgedRun:
    return replace(
        run, margins=tuple(DIFFERENT if margin.check == REPEATED else margin for margin in run.margins)
    )
