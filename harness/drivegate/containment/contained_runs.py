"""Doing something with a candidate many times inside a task, whatever becomes of each."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import Fault
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job, JudgedCandidate

PayloadT = TypeVar("PayloadT")
ResultT = TypeVar("ResultT")


def contained_runs(
    candidate: Candidate,
    target: Callable[[JudgedCandidate, PayloadT], ResultT],
    payloads: Iterable[PayloadT],
) -> Iterator[ResultT | Fault]:
    """Do something with a candidate many times, each time with a new instance, whatever becomes of the others.

    The candidate's process lives as long as the iteration, and no longer: what a candidate keeps for itself between
    runs depends on the payloads alone, never on how they are shared among processes.
    """
    refused: Fault | None = None
    with Judge(candidate) as judge:
        for payload in payloads:
            if refused is None:
                ending = judge.run(Job(target, payload))
                if isinstance(ending, Fault) and ending.phase == "loading":
                    refused = ending
                yield ending
            else:
                yield refused
