"""Two candidates that answer with duty ratios: one drives the plant, the other is given the same."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import Fault
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job
from drivegate.output.compiled_kernels import with_compiled_kernels
from drivegate.studies.diff.duty.steps import AnswerRequest, DrivenRun, answer_run, drive_run
from drivegate.studies.diff.jobs import Rule
from drivegate.studies.diff.leading import led
from drivegate.studies.diff.outcome import SECOND, StepComparison
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.loop.step_recording import differs


@dataclass(frozen=True)
class DutyDifference:
    """The first step at which two candidates differ, and what is around it."""

    step: int
    begin: int
    end: int
    """Number of the step, and the first and the one behind the last of those around it."""
    driven: DrivenRun
    """The run of the first candidate."""
    answers: NDArray[Any]
    """The second candidate's commands from the first step of all on, up to a fault, shape (n,)."""


def duty_compared(
    first: Candidate,
    second: Candidate,
    scenario: Scenario,
    rule: Rule,
    *,
    before: int,
    after: int,
    again: bool = False,
) -> StepComparison[DutyDifference]:
    """Compare two candidates step by step, as `drivegate.studies.diff.diff.compared` does."""
    with_compiled_kernels([scenario.drive])
    with Judge(second) as following:
        driven = led(first, following, Job(drive_run, scenario))
        if isinstance(driven, StepComparison):
            return driven
        answered = following.run(Job(answer_run, AnswerRequest(scenario, driven, again)))
    if isinstance(answered, Fault):
        return StepComparison(answered.step or 0, fault=answered, faulted=SECOND)
    step = first_difference(driven.run.commands, answered.commands, rule)
    if step is not None:
        begin, end = max(step - before, 0), min(step + 1 + after, len(answered.commands))
        return StepComparison(step, DutyDifference(step, begin, end, driven, answered.commands))
    if answered.fault is not None:
        return StepComparison(len(answered.commands), fault=answered.fault, faulted=SECOND)
    return StepComparison(len(answered.commands))


def first_difference(commands: NDArray[Any], answers: NDArray[Any], rule: Rule) -> int | None:
    """Find the first answer that differs from a command in a field that is judged; None where none does."""
    for step in np.flatnonzero(_any_bit(commands[: len(answers)], answers, rule)):
        if any(differ(name, commands[step], answers[step], rule) for name in rule.judged):
            return int(step)
    return None


def _any_bit(commands: NDArray[Any], answers: NDArray[Any], rule: Rule) -> NDArray[np.bool_]:
    """Tell of each step whether any bit of a judged field differs."""
    found = np.zeros(len(answers), np.bool_)
    for name in rule.judged:
        one, other = (np.ascontiguousarray(rows[name]).view(np.int64) for rows in (commands, answers))
        found |= one != other
    return found


def differ(name: str, one: Any, other: Any, rule: Rule) -> bool:
    """Tell whether a field of two commands differs; whole numbers do so by any."""
    first, second = one[name], other[name]
    if isinstance(first, np.integer):
        return bool(first != second)
    one_bits, other_bits = (int(value.view(np.int64)) for value in (first, second))
    return bool(differs(float(first), float(second), one_bits, other_bits, rule.tolerance))
