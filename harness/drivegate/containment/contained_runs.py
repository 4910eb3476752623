"""Making runs of one candidate inside a task: drivegate's own controllers here, all others in a process of theirs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
from typing import TypeVar

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import CandidateFault, Fault
from drivegate.candidates.kinds import KINDS
from drivegate.candidates.loading import load_controller
from drivegate.containment.messages import Job, LoadedCandidate
from drivegate.containment.shared_progress import SharedProgress
from drivegate.containment.worker import CandidateWorker

PayloadT = TypeVar("PayloadT")
ResultT = TypeVar("ResultT")


def contained_runs(
    candidate: Candidate,
    target: Callable[[LoadedCandidate, PayloadT], ResultT],
    payloads: Iterable[PayloadT],
) -> Iterator[ResultT | Fault]:
    """Do something with a candidate many times, each time with a new instance, whatever becomes of the others.

    The candidate's process lives as long as the iteration, and no longer: what a candidate keeps for itself between
    runs depends on the payloads alone, never on how they are shared among processes. A built-in candidate, whose code
    is drivegate's own, needs none.
    """
    if KINDS[candidate.kind].comes_along:
        yield from _uncontained_runs(candidate, target, payloads)
        return
    refused: Fault | None = None
    with CandidateWorker(candidate, load_controller) as worker:
        for payload in payloads:
            if refused is None:
                ending = worker.run(Job(target, payload))
                if isinstance(ending, Fault) and ending.phase == "loading":
                    refused = ending
                yield ending
            else:
                yield refused


def _uncontained_runs(
    candidate: Candidate,
    target: Callable[[LoadedCandidate, PayloadT], ResultT],
    payloads: Iterable[PayloadT],
) -> Iterator[ResultT | Fault]:
    loaded = LoadedCandidate(candidate, load_controller, _unshared_progress())
    for payload in payloads:
        try:
            yield target(loaded, payload)
        except CandidateFault as error:
            yield error.fault


@lru_cache(maxsize=1)
def _unshared_progress() -> SharedProgress:
    """Make the record that a run writes its progress into, which nobody reads here."""
    return SharedProgress.create()
