"""The first candidate of a comparison drives the plant, once the second one is known to load."""

from __future__ import annotations

from typing import Any, TypeVar

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import Fault
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job
from drivegate.studies.diff.jobs import load_only
from drivegate.studies.diff.outcome import FIRST, SECOND, StepComparison

LedT = TypeVar("LedT")


def led(first: Candidate, following: Judge, job: Job[LedT]) -> LedT | StepComparison[Any]:
    """Do the first candidate's job; a fault of either ends the comparison.

    The second one is loaded before the long run, so that one that is refused is reported at once.
    """
    loading = following.run(Job(load_only, None))
    if isinstance(loading, Fault):
        return StepComparison(0, fault=loading, faulted=SECOND)
    with Judge(first) as leading:
        driven = leading.run(job)
    if isinstance(driven, Fault):
        return StepComparison(driven.step or 0, fault=driven, faulted=FIRST)
    return driven
