"""The parts of a comparison step by step: write the record of one candidate, have the other one answer to it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.controller import Controller, show_drive
from drivegate.candidates.fault import CandidateFault
from drivegate.containment.messages import JudgedCandidate
from drivegate.contracts.current.scripted import GivenSteps
from drivegate.drives.running import run_scenario
from drivegate.studies.diff.record import RecordingController, recorded_rows
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.loop.exchange import OUTPUTS
from drivegate_models.loop.step_recording import first_difference, senses_in

BITWISE: Final = -1.0
"""The tolerance that leaves no bit free."""


@dataclass(frozen=True)
class Rule:
    """When two commands count as different."""

    tolerance: float = BITWISE
    """Greatest difference of a number, relative to the larger one, absolute where that is below 1; `BITWISE`
    for none."""
    judged: tuple[str, ...] = OUTPUTS
    """The fields that are compared."""


@dataclass(frozen=True)
class RecordRequest:
    """What is to be recorded of the first candidate."""

    path: Path
    """The file to write."""
    scenario: Scenario
    """The scenario."""


@dataclass(frozen=True)
class Shadowing:
    """What the second candidate is to answer."""

    path: Path
    """The record."""
    scenario: Scenario
    """Its scenario."""
    rule: Rule | None
    """When to stop; None to go on to the end whatever it answers."""
    begin: int
    end: int
    """The first step whose answer is kept, and the one to stop before."""
    again: bool = False
    """Whether the instance has run the scenario once before, and was reset."""


@dataclass(frozen=True)
class Shadowed:
    """How the second candidate answered."""

    differs: int | None
    """The step of the first difference."""
    answers: NDArray[np.float64]
    """The commands that were requested, shape (n, 3)."""


def load_only(loaded: JudgedCandidate, _payload: None) -> None:
    """Make an instance, and see whether it can be made."""
    loaded.controller()


def record_run(loaded: JudgedCandidate, plan: RecordRequest) -> None:
    """Run a scenario and write the record of every step."""
    recorders: list[RecordingController] = []
    with plan.path.open("wb") as file:

        def recording(inner: Controller) -> Controller:
            recorders.append(RecordingController(inner, file, plan.scenario.drive.machine.phases))
            return recorders[-1]

        run_scenario(plan.scenario, loaded.controller(), wrap=recording)
        recorders[-1].finish()


def shadow_run(loaded: JudgedCandidate, plan: Shadowing) -> Shadowed:
    """Give a candidate what the record has sensed, until it answers otherwise."""
    nameplate = plan.scenario.nameplate()
    controller = loaded.controller()
    if plan.again:
        run_scenario(plan.scenario, controller)
    show_drive(controller, plan.scenario.drive)
    steps = GivenSteps(controller, nameplate)
    kept: list[NDArray[np.float64]] = [np.empty((0, len(OUTPUTS)))]
    done = 0
    restarts = {round(time / nameplate.control_period) for time in plan.scenario.restarts_s}
    blocks = recorded_rows(plan.path, nameplate.phases, plan.end)
    for rows in _divided(blocks, restarts):
        if done in restarts:
            steps.restart()
        answers, fault = _answers(steps, senses_in(rows))
        if plan.rule is not None:
            rule = plan.rule
            differs = first_difference(rows, answers, judged=rule.judged, tolerance=rule.tolerance)
            if differs is not None:
                return Shadowed(done + differs, np.concatenate(kept))
        if fault is not None:
            raise fault
        kept.append(answers[max(plan.begin - done, 0) :])
        done += len(rows)
    return Shadowed(None, np.concatenate(kept))


def _answers(
    steps: GivenSteps, senses: NDArray[np.float64]
) -> tuple[NDArray[np.float64], CandidateFault | None]:
    """Give the answers up to a fault, and the fault."""
    try:
        return steps.answers(senses), None
    except CandidateFault as fault:
        return steps.last_answers, fault


def _divided(blocks: Iterable[NDArray[np.float64]], steps: set[int]) -> Iterator[NDArray[np.float64]]:
    """Cut blocks of steps so that each of the given steps is the first of one."""
    done = 0
    for rows in blocks:
        inside = sorted(step - done for step in steps if done < step < done + len(rows))
        yield from np.split(rows, inside)
        done += len(rows)
