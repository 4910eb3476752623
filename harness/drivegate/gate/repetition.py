"""The same scenario once more in another process: what `DET-1` cannot see from within one (a process id, say)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from numpy.typing import NDArray

from drivegate.candidates.fault import Fault
from drivegate.checks.check import JudgedRun
from drivegate.checks.margin import Margin
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.containment.pool import WorkerPool
from drivegate.contracts.parting import SEED_IN_RESET, empty_commands, parting_of
from drivegate.drives.running import recorded
from drivegate.gate.plan import REPEATED
from drivegate_cases.documents.document import parse_document
from drivegate_cases.scenario.scenario import Scenario

_EARLIER: Final = (
    "the repetition in another process differs, and two processes that have done nothing before agree: "
    "what a process has run earlier changes the answer"
)


@dataclass(frozen=True)
class Repetition:
    """A run of a scenario in a process that has done nothing before."""

    digest: int
    """Digest of its commands."""
    commands: NDArray[Any] | None = None
    """The commands themselves, where they are asked for, shape (n,)."""


@dataclass(frozen=True)
class _Request:
    scenario: Scenario
    keep: bool


def repetition_job(scenario: Scenario, *, keep: bool = False) -> Job[Repetition]:
    """Plan to run a scenario in a process that has done nothing before."""
    return Job(run_repetition, _Request(scenario, keep), afresh=True, is_plain=True)


def run_repetition(loaded: JudgedCandidate, request: _Request) -> Repetition:
    """Run a scenario; this is what the worker process does."""
    kept = empty_commands(request.scenario) if request.keep else None
    record = recorded(loaded, request.scenario, loaded.controller(), kept=kept)
    return Repetition(record.run.digest, kept)


def explanation_jobs(scenario: Scenario) -> list[Job[Repetition]]:
    """Plan two runs in processes of their own, whose commands show what two processes do differently.

    The commands of the run that the repetition differed from are not kept all the time.
    """
    return [repetition_job(scenario, keep=True) for _ in range(2)]


def different_elsewhere(scenario: Scenario, endings: Sequence[Repetition | Fault]) -> Margin:
    """Return what `DET-1` comes to where another process answers differently, with where two of them part."""
    commands = [ending.commands for ending in endings if isinstance(ending, Repetition)]
    parting = None
    if len(commands) == 2 and commands[0] is not None and commands[1] is not None:
        parting = parting_of(scenario, commands[1], commands[0])
    words = _EARLIER if parting is None else f"the repetition in another process {parting}; {SEED_IN_RESET}"
    return Margin(REPEATED, -1.0, words)


def repeated_elsewhere(pool: WorkerPool, runs: Sequence[JudgedRun]) -> Iterator[JudgedRun | Fault]:
    """Repeat those runs in other processes whose repetitions have been the same so far."""
    repeated = [run for run in runs if _repeats_itself(run)]
    mapped = pool.map([repetition_job(_scenario_of(run)) for run in repeated])
    endings = iter(list(mapped))
    for run in runs:
        ending = next(endings) if _repeats_itself(run) else Repetition(run.digest)
        if isinstance(ending, Fault):
            yield ending
        same = isinstance(ending, Fault) or ending.digest == run.digest
        yield run if same else _corrected(pool, run)


def _repeats_itself(run: JudgedRun) -> bool:
    return any(margin.check == REPEATED and margin.met for margin in run.margins)


def _scenario_of(run: JudgedRun) -> Scenario:
    return parse_document(run.scenario, Scenario, "a scenario of the check")


def _corrected(pool: WorkerPool, run: JudgedRun) -> JudgedRun:
    scenario = _scenario_of(run)
    mapped = pool.map(explanation_jobs(scenario))
    different = different_elsewhere(scenario, list(mapped))
    return replace(
        run, margins=tuple(different if margin.check == REPEATED else margin for margin in run.margins)
    )
