"""Two candidates step by step: one drives the plant, the other senses the same and must answer the same."""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.controller import Controller, show_drive
from drivegate.candidates.fault import CandidateFault, Fault
from drivegate.candidates.step_costs import NO_COSTS, StepCosts
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.containment.temporary_folder import temporary_folder
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.given_steps import RecordingController
from drivegate.drives.kinds import kind_of
from drivegate.drives.running import run_scenario, taken_costs
from drivegate.output.waiting import with_compiled_kernels
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_cases.scenario.reference import reference_of
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError
from drivegate_models.loop.step_recording import row_layout

BITWISE: Final = -1.0
"""The tolerance that leaves no bit free."""
BLOCK: Final = 10_000
"""Steps that are answered at once."""
FIRST: Final = "first"
SECOND: Final = "second"


@dataclass(frozen=True)
class Rule:
    """When two commands count as different."""

    tolerance: float = BITWISE
    """Greatest difference of a number, relative to the larger one, absolute where that is below 1; `BITWISE`
    for none."""
    ignored: tuple[str, ...] = ()

    def judged(self, fields: Iterable[str]) -> tuple[str, ...]:
        return tuple(name for name in fields if name not in self.ignored)


def first_difference(commands: NDArray[Any], answers: NDArray[Any], rule: Rule) -> int | None:
    """Find the first answer that differs from a command in a field that is judged; None where none does."""
    found = np.zeros(len(answers), np.bool_)
    # The first field is the size of the record.
    for name in rule.judged((commands.dtype.names or ())[1:]):
        found |= differing(commands[name][: len(answers)], answers[name], rule.tolerance)
    return int(np.argmax(found)) if found.any() else None


def differing(one: NDArray[Any], other: NDArray[Any], tolerance: float) -> NDArray[np.bool_]:
    """Return of each pair of numbers whether they differ: by any bit, or by more than a tolerance.

    Two NaN do not differ; whole numbers do by any difference.
    """
    apart: NDArray[np.bool_]
    if one.dtype.kind != "f":
        apart = one != other
        return apart
    if tolerance < 0.0:
        apart = one.view(np.int64) != other.view(np.int64)
    else:
        # The difference of two infinite numbers is none.
        with np.errstate(invalid="ignore", over="ignore"):
            largest = np.maximum(1.0, np.maximum(np.abs(one), np.abs(other)))
            apart = np.abs(one - other) > tolerance * largest
    nan, other_nan = np.isnan(one), np.isnan(other)
    either = nan | other_nan
    apart[either] = (nan != other_nan)[either]
    return apart


@dataclass(frozen=True)
class RecordRequest:
    """What is to be recorded of the first candidate."""

    path: Path
    scenario: Scenario


@dataclass(frozen=True)
class FollowRequest:
    """What the second candidate is to answer."""

    path: Path
    scenario: Scenario
    rule: Rule
    before: int
    after: int
    """Numbers of answers to return from before and after the first difference."""
    again: bool = False
    """Whether the instance has run the scenario once before, and was reset."""


@dataclass(frozen=True)
class Followed:
    """How the second candidate answered."""

    costs: StepCosts
    """Greatest costs of a step on an emulated target."""
    step: int | None
    """The step of the first difference; None for none."""
    begin: int
    """The step of the first answer."""
    answers: NDArray[Any]
    """Its commands from there on, up to a fault, as records of the contract; empty without a difference."""


def load_only(loaded: JudgedCandidate, _payload: None) -> None:
    """Make an instance, and see whether it can be made."""
    loaded.controller()


def refuse_a_full_disk(scenario: Scenario, folder: Path) -> None:
    """Refuse a run whose record would not fit on the disk."""
    needed = scenario.control_periods * _row_of(scenario).itemsize
    free = shutil.disk_usage(folder).free
    if needed > free:
        raise InputError(
            f"the record of {scenario.duration_s:g} s would take {needed / 1e9:.1f} GB, but {shown_path(folder)} has "
            f"{free / 1e9:.1f} GB left; take a shorter scenario, or a folder with more room as TMPDIR"
        )


def record_run(loaded: JudgedCandidate, plan: RecordRequest) -> StepCosts:
    """Run a scenario and write the record of every step; return the greatest costs of one."""
    rows = np.memmap(plan.path, _row_of(plan.scenario), "w+", shape=(plan.scenario.control_periods,))
    controller = loaded.controller()
    _run_once(loaded, plan.scenario, controller, rows)
    rows.flush()
    return taken_costs(controller)


def recorded_rows(path: Path, scenario: Scenario) -> NDArray[Any]:
    """Open a record, shape (control periods,)."""
    return np.memmap(path, _row_of(scenario), "r")


def follow_run(loaded: JudgedCandidate, plan: FollowRequest) -> Followed:
    """Pass on to a candidate what was sensed, until it answers otherwise."""
    contract, rows = contract_of(plan.scenario.drive), recorded_rows(plan.path, plan.scenario)
    controller = loaded.controller()
    if plan.again:
        _run_once(loaded, plan.scenario, controller)
    show_drive(controller, plan.scenario.drive)
    nameplate = contract.nameplate(plan.scenario, **_reference_options(loaded.candidate, plan.scenario))
    steps = contract.given_steps(controller, nameplate)
    restarts = {round(time / plan.scenario.control_period_s) for time in plan.scenario.restarts_s}
    differs: int | None = None
    answers = np.empty(0, contract.layout.command)
    for begin, end in _blocks(len(rows), restarts):
        if differs is not None and begin > differs + plan.after:
            break
        if begin in restarts:
            steps.restart()
        block, fault = rows[begin:end], None
        try:
            answered = steps.answers(block["sense"], block["currents"])
        except CandidateFault as ended:
            answered, fault = steps.last_answers, ended
        if differs is None:
            found = first_difference(block["command"], answered, plan.rule)
            differs = None if found is None else begin + found
            # Nothing else from before a difference is shown.
            answers = answers[max(len(answers) - plan.before, 0) :]
        answers, done = np.concatenate([answers, answered]), begin + len(answered)
        if fault is not None:
            if differs is None:
                raise fault
            break
    costs = taken_costs(controller)
    if differs is None:
        return Followed(costs, None, 0, answers[:0])
    first, begin = done - len(answers), max(differs - plan.before, 0)
    return Followed(costs, differs, begin, answers[begin - first : differs + 1 + plan.after - first])


def _blocks(steps: int, restarts: set[int]) -> Iterator[tuple[int, int]]:
    """Divide steps so that each restart begins a block."""
    return pairwise(sorted({*range(0, steps, BLOCK), *(step for step in restarts if step < steps), steps}))


def gets_current(candidate: Candidate, scenario: Scenario) -> bool:
    """Return True if a candidate gets a q current in place of the scenario's torque."""
    return candidate.declaration.follows_current and reference_of(scenario) == "torque"


def _reference_options(candidate: Candidate, scenario: Scenario) -> dict[str, bool]:
    """Return the options of a run in which a candidate gets a q current."""
    return {"follows_current": True} if gets_current(candidate, scenario) else {}


def _run_once(
    loaded: JudgedCandidate, scenario: Scenario, controller: Any, rows: NDArray[Any] | None = None
) -> None:
    """Run a controller, and record its steps where there is room for them."""

    def recording(inner: Controller) -> Controller:
        return inner if rows is None else RecordingController(inner, rows)

    run_scenario(scenario, controller, wrap=recording, **_reference_options(loaded.candidate, scenario))


def _row_of(scenario: Scenario) -> np.dtype[Any]:
    return row_layout(contract_of(scenario.drive).layout, scenario.drive.machine.phases)


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
    fault: Fault | None = None
    """The fault of one of them."""
    faulted: str | None = None
    """Which one."""
    costs: tuple[StepCosts, StepCosts] = (NO_COSTS, NO_COSTS)
    """Greatest costs of a step of both on an emulated target."""


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
        refuse_a_full_disk(scenario, folder)
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
        rows, costs = recorded_rows(path, scenario), (recorded, ended.costs)
        if ended.step is None:
            return StepComparison(len(rows), costs=costs)
        prepare = kind_of(scenario.drive).prepare_loop()
        plant = contract_of(scenario.drive).plant_state(prepare, scenario, rows["command"], ended.step)
        around = rows[ended.begin : ended.step + 1 + after].copy()
        found = Difference(ended.step, ended.begin, plant, around, ended.answers)
        return StepComparison(ended.step, found, costs=costs)
