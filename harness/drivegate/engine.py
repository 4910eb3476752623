"""The check of a candidate: plan, work in contained processes, verdict. It tells what it does as events."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, Final

from drivegate.candidate import Candidate
from drivegate.controller_loading import load_controller
from drivegate.events import CheckFinished, CheckStarted, Compiling, Event, RunDone
from drivegate.fault import Fault, FaultKind
from drivegate.fixed_scenarios import REFERENCE_MOTOR, fixed_scenarios
from drivegate.margin import Margin
from drivegate.provenance import provenance
from drivegate.result import CheckResult
from drivegate.search_shard import DrawnRuns, FixedRuns, JudgedRun, ShardOutcome, run_drawn, run_fixed
from drivegate.verdict import candidate_verdict, check_outcomes
from drivegate.warm_up import compile_kernels, missing_marker
from drivegate.worker_messages import Job
from drivegate.worker_pool import WorkerPool
from drivegate_models.errors import InputError

EXAMPLES: Final = {"quick": 2, "default": 12, "nightly": 150}
"""Scenarios drawn in each shard, by effort."""
SHARDS: Final = 8
"""Number of seeded shards, whatever the number of workers."""


@dataclass(frozen=True)
class _Work:
    job: Job[ShardOutcome]
    runs: int
    label: str


def _planned(effort: str, seed: int) -> list[_Work]:
    fixed = fixed_scenarios()
    work = [_Work(Job(run_fixed, FixedRuns(fixed[:2], repeat=True)), 2, fixed[1].name)]
    work += [_Work(Job(run_fixed, FixedRuns((scenario,))), 1, scenario.name) for scenario in fixed[2:]]
    examples = EXAMPLES[effort]
    work += [
        _Work(
            Job(run_drawn, DrawnRuns(REFERENCE_MOTOR, seed * SHARDS + shard, examples)),
            examples,
            f"shard {shard + 1}",
        )
        for shard in range(SHARDS)
    ]
    return work


def check_candidate(
    candidate: Candidate,
    *,
    effort: str = "default",
    seed: int = 0,
    workers: int | None = None,
    max_time: float | None = None,
) -> Iterator[Event]:
    """Check a candidate, and tell what is done as events.

    Parameters
    ----------
    candidate : Candidate
        The candidate.
    effort : {"default", "quick", "nightly"}
        Number of scenarios drawn.
    seed : int
        Seed of the search, 0 or more.
    workers : int, optional
        Number of worker processes; by default as many as there are processors. The result does not depend on it.
    max_time : float, optional
        Time after which no more work is begun (s); what is left makes the checks inconclusive.

    Yields
    ------
    Event
        The last one holds the result.

    Raises
    ------
    InputError
        When an option is out of range or the candidate is refused.
    HarnessFault
        When the harness itself fails.
    """
    if effort not in EXAMPLES:
        raise InputError(f"the effort is '{effort}', but must be one of {', '.join(EXAMPLES)}")
    if seed < 0:
        raise InputError(f"the seed is {seed}, but must be 0 or more")
    started = datetime.now(UTC)
    began = time.monotonic()
    count = workers or os.cpu_count() or 1
    work = _planned(effort, seed)
    planned = sum(item.runs for item in work)
    yield CheckStarted(candidate.name, planned)
    marker = missing_marker()
    if marker is not None:
        yield Compiling()
        compile_kernels(marker)

    runs: list[JudgedRun] = []
    faults: list[Fault] = []
    set_aside = 0
    done = 0
    complete = True
    with WorkerPool(candidate, load_controller, workers=count) as pool:
        outcomes = pool.map([item.job for item in work])
        for item, outcome in zip(work, outcomes, strict=True):
            done += item.runs
            if isinstance(outcome, Fault):
                if (outcome.kind, outcome.message) not in [(fault.kind, fault.message) for fault in faults]:
                    faults.append(outcome)
            else:
                runs.extend(outcome.runs)
                set_aside += outcome.set_aside
            yield RunDone(done, planned, item.label, _worst(runs))
            if max_time is not None and time.monotonic() - began > max_time and done < planned:
                complete = False
                break
    outcomes_by_check = check_outcomes(runs, complete=complete and not faults)
    if any(outcome.id == "DET-1" and outcome.verdict == "fail" for outcome in outcomes_by_check):
        message = "the same scenario was answered differently when it was repeated"
        faults.append(Fault(FaultKind.NON_DETERMINISTIC, message, "step"))
    verdict, exit_code = candidate_verdict(outcomes_by_check, faults)
    timing: dict[str, Any] = {
        "started_utc": started.isoformat(timespec="seconds"),
        "seconds": round(time.monotonic() - began, 3),
        "workers": count,
    }
    yield CheckFinished(
        CheckResult(
            candidate=candidate,
            verdict=verdict,
            exit_code=exit_code,
            seed=seed,
            effort=effort,
            checks=outcomes_by_check,
            faults=tuple(faults),
            runs=len(runs),
            set_aside=set_aside,
            provenance=provenance(),
            timing=timing,
        )
    )


def _worst(runs: list[JudgedRun]) -> str:
    margins: list[Margin] = [margin for run in runs for margin in run.margins if not margin.advisory]
    if not margins:
        return ""
    least = min(margins, key=lambda margin: margin.value)
    return f"{least.check} {least.value:+.3g}"
