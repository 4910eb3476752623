"""Two candidates step by step: one drives the plant, the other is given the same and must answer the same."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import Fault
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job
from drivegate.containment.temporary_folder import temporary_folder
from drivegate.output.compiled_kernels import with_compiled_kernels
from drivegate.studies.diff.jobs import (
    RecordRequest,
    Rule,
    Shadowing,
    record_run,
    shadow_run,
)
from drivegate.studies.diff.leading import led
from drivegate.studies.diff.outcome import SECOND, StepComparison
from drivegate.studies.diff.plant_playback import PlantState, plant_at
from drivegate.studies.diff.record import (
    refuse_without_room,
    row_count,
    some_rows,
)
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.contract.current.signals import Sense
from drivegate_models.loop.exchange import OUTPUTS


@dataclass(frozen=True)
class Difference:
    """The first step at which two candidates differ, and what is around it."""

    step: int
    """Number of the step, from 0."""
    sense: Sense
    """What both sensed."""
    plant: PlantState
    """State of the plant at the start of that step."""
    begin: int
    """Step of the first row."""
    rows: NDArray[np.float64]
    """The record of the first candidate from there on, shape (n, row_length(phases)."""
    answers: NDArray[np.float64]
    """The second candidate's commands for these rows, or for the first of them, shape (k, 3)."""


def compared(
    first: Candidate,
    second: Candidate,
    scenario: Scenario,
    rule: Rule,
    *,
    before: int,
    after: int,
    again: bool = False,
) -> StepComparison[Difference]:
    """Compare two candidates step by step.

    The first one drives the plant, and every step is recorded. The second one is then given the same, until it answers
    otherwise. Both are alike up to there, so nothing is lost by asking one after the other.
    With `again` the second one's instance has run the scenario before: against itself, that shows what reset keeps.
    """
    with_compiled_kernels([scenario.drive])
    with temporary_folder() as folder:
        refuse_without_room(scenario, folder)
        path = folder / "steps"
        with Judge(second) as following:
            recorded = led(first, following, Job(record_run, RecordRequest(path, scenario)))
            if isinstance(recorded, StepComparison):
                return recorded
            end = row_count(path, scenario.drive.machine.phases)
            plan = Shadowing(path, scenario, rule, end, end, again)
            ended = following.run(Job(shadow_run, plan))
            if isinstance(ended, Fault):
                return StepComparison(ended.step or 0, fault=ended, faulted=SECOND)
            if ended.differs is None:
                return StepComparison(end)
            difference = _difference(following, plan, ended.differs, before, after)
            return StepComparison(ended.differs, difference)


def _difference(following: Judge, plan: Shadowing, step: int, before: int, after: int) -> Difference:
    scenario, phases = plan.scenario, plan.scenario.drive.machine.phases
    begin, end = max(step - before, 0), min(step + 1 + after, plan.end)
    around = following.run(Job(shadow_run, Shadowing(plan.path, scenario, None, begin, end, plan.again)))
    if isinstance(around, Fault):
        # It does not survive what comes after its different answer, but comes as far as that again.
        shorter = Shadowing(plan.path, scenario, None, begin, step + 1, plan.again)
        around = following.run(Job(shadow_run, shorter))
    answers = np.empty((0, len(OUTPUTS))) if isinstance(around, Fault) else around.answers
    rows = some_rows(plan.path, phases, begin, end)
    return Difference(
        step, _sense_of(rows[step - begin]), plant_at(plan.path, scenario, step), begin, rows, answers
    )


def _sense_of(row: NDArray[np.float64]) -> Sense:
    time, speed_reference, speed, magnitude_sum, voltage, *others = row.tolist()
    return Sense(time, speed_reference, speed, tuple(others[len(OUTPUTS) :]), magnitude_sum, voltage)
