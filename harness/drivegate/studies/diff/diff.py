"""Two candidates step by step: one drives the plant, the other senses the same and must answer the same."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from numpy.typing import NDArray

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import Fault
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job
from drivegate.containment.temporary_folder import temporary_folder
from drivegate.contracts.catalogue import contract_of
from drivegate.drives.kinds import kind_of
from drivegate.output.waiting import with_compiled_kernels
from drivegate.studies.diff.jobs import (
    Followed,
    FollowRequest,
    RecordRequest,
    Rule,
    follow_run,
    gets_current,
    load_only,
    record_run,
    recorded_rows,
    refuse_without_room,
)
from drivegate_cases.documents.wording import one_line
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError

FIRST: Final = "first"
SECOND: Final = "second"


@dataclass(frozen=True)
class Difference:
    """The first step at which two candidates differ, and what is around it."""

    step: int
    begin: int
    """Number of the step, from 0, and that of the first row."""
    plant: dict[str, Any]
    """The plant's own state at the start of that step."""
    rows: NDArray[Any]
    """What was sensed and what the first candidate answered: `sense`, `currents` and `command`, shape (n,)."""
    answers: NDArray[Any]
    """The second candidate's commands for these rows, or for the first of them, shape (k,)."""


@dataclass(frozen=True)
class StepComparison:
    """The outcome of a comparison."""

    steps: int
    """Number of steps at which both answered the same."""
    difference: Difference | None = None
    """The first difference."""
    fault: Fault | None = None
    """The fault of one of them."""
    faulted: str | None = None
    """Which one."""


def compared(
    first: Candidate,
    second: Candidate,
    scenario: Scenario,
    rule: Rule,
    *,
    before: int,
    after: int,
    again: bool = False,
) -> StepComparison:
    """Compare two candidates step by step.

    The first one drives the plant, and every step is recorded. The second one then senses the same, until it answers
    otherwise. Both are the same up to there, so nothing is lost by asking one after the other.
    With `again` the second one's instance has run the scenario before: against itself, that shows what reset keeps.
    """
    of_current = [candidate for candidate in (first, second) if gets_current(candidate, scenario)]
    if len(of_current) == 1:
        raise InputError(
            f"the candidate '{one_line(of_current[0].name)}' declares 'references = [\"current\"]', but the other one "
            "gets the torque of the scenario; compare candidates that follow the same"
        )
    with_compiled_kernels([scenario.drive])
    with temporary_folder() as folder, Judge(second) as following:
        refuse_without_room(scenario, folder)
        path = folder / "steps"
        # One that cannot be loaded is refused before the long run.
        loading = following.run(Job(load_only, None))
        if isinstance(loading, Fault):
            return StepComparison(0, fault=loading, faulted=SECOND)
        with Judge(first) as leading:
            recorded = leading.run(Job(record_run, RecordRequest(path, scenario)))
        if isinstance(recorded, Fault):
            return StepComparison(recorded.step or 0, fault=recorded, faulted=FIRST)
        ended = following.run(Job(follow_run, FollowRequest(path, scenario, rule, before, after, again)))
        if isinstance(ended, Fault):
            return StepComparison(ended.step or 0, fault=ended, faulted=SECOND)
        rows = recorded_rows(path, scenario)
        if ended is None:
            return StepComparison(len(rows))
        return StepComparison(ended.step, _difference(ended, rows, scenario, after))


def _difference(ended: Followed, rows: NDArray[Any], scenario: Scenario, after: int) -> Difference:
    prepare = kind_of(scenario.drive).prepare_loop()
    plant = contract_of(scenario.drive).plant_state(prepare, scenario, rows["command"], ended.step)
    around = rows[ended.begin : ended.step + 1 + after].copy()
    return Difference(ended.step, ended.begin, plant, around, ended.answers)
