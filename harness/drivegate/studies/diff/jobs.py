"""What the worker processes do in a comparison step by step: write the record, answer to it, play it back."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.fault import CandidateFault, Fault, FaultKind
from drivegate.containment.messages import LoadedCandidate
from drivegate.drives.running import run_scenario
from drivegate.studies.diff.plant_playback import PlantState, plant_at
from drivegate.studies.diff.record import RecordingController, recorded_rows
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.contract.outer_loop.signals import Sense
from drivegate_models.loop.exchange import NOT_FINITE, STOPPED
from drivegate_models.loop.step_recording import DIFFERS, OUTPUTS, Shadow

BITWISE: Final = -1.0
"""The tolerance that leaves no bit free."""


@dataclass(frozen=True)
class Rule:
    """When two commands count as different.

    Attributes
    ----------
    tolerance : float
        Greatest difference of a number, relative to the larger one, absolute where that is below 1; `BITWISE` for
        none.
    judged : tuple of str
        The fields that are compared.
    """

    tolerance: float = BITWISE
    judged: tuple[str, ...] = OUTPUTS


@dataclass(frozen=True)
class RecordRequest:
    """What the first candidate's process is to record.

    Attributes
    ----------
    path : Path
        The file to write.
    scenario : Scenario
        The scenario.
    """

    path: Path
    scenario: Scenario


@dataclass(frozen=True)
class Shadowing:
    """What the second candidate's process is to answer.

    Attributes
    ----------
    path : Path
        The record.
    scenario : Scenario
        Its scenario.
    rule : Rule or None
        When to stop; None to go on to the end whatever it answers.
    begin, end : int
        The first step whose answer is kept, and the one to stop before.
    """

    path: Path
    scenario: Scenario
    rule: Rule | None
    begin: int
    end: int


@dataclass(frozen=True)
class Shadowed:
    """How the second candidate answered.

    Attributes
    ----------
    differs : int or None
        The step of the first difference.
    answers : ndarray, shape (n, 3)
        The commands that were requested.
    """

    differs: int | None
    answers: NDArray[np.float64]


def load_only(loaded: LoadedCandidate, _payload: None) -> None:
    """Make an instance, and see whether it can be made."""
    loaded.controller()


def record_run(loaded: LoadedCandidate, plan: RecordRequest) -> None:
    """Run a scenario and write the record of every step; this is what the first worker process does."""
    with plan.path.open("wb") as file:
        controller = RecordingController(loaded.controller(), file, plan.scenario.motor.phases)
        run_scenario(plan.scenario, controller, progress=loaded.progress)
        controller.finish()


def shadow_run(loaded: LoadedCandidate, plan: Shadowing) -> Shadowed:
    """Give a candidate what is on record, until it answers otherwise; this is what the second worker process does."""
    nameplate = plan.scenario.nameplate()
    controller, progress = loaded.controller(), loaded.progress
    judged, tolerance = (plan.rule.judged, plan.rule.tolerance) if plan.rule else ((), BITWISE)
    kept: list[NDArray[np.float64]] = [np.empty((0, len(OUTPUTS)))]
    with progress.run():
        controller.reset(nameplate)
        shadow = Shadow(
            step_address=controller.step_address,
            state_address=controller.state_address,
            phases=nameplate.phases,
            sense=progress.sense,
            sensed_currents=progress.phase_currents,
            progress=progress.steps,
        )
        done = 0
        restarts = {round(time / nameplate.control_period) for time in plan.scenario.restarts_s}
        blocks = recorded_rows(plan.path, nameplate.phases, plan.end)
        for rows in _divided(blocks, restarts):
            if done in restarts:
                controller.reset(nameplate)
            status, alike, answers = shadow.answer(rows, judged=judged, tolerance=tolerance)
            if status in (STOPPED, NOT_FINITE):
                raise CandidateFault(controller.fault or _not_finite(shadow, done + alike))
            if status == DIFFERS:
                return Shadowed(done + alike, np.concatenate(kept))
            kept.append(answers[max(plan.begin - done, 0) :])
            done += len(rows)
    return Shadowed(None, np.concatenate(kept))


def _divided(blocks: Iterable[NDArray[np.float64]], steps: set[int]) -> Iterator[NDArray[np.float64]]:
    """Cut blocks of steps so that each of the given steps is the first of one."""
    done = 0
    for rows in blocks:
        inside = sorted(step - done for step in steps if done < step < done + len(rows))
        yield from np.split(rows, inside)
        done += len(rows)


def _not_finite(shadow: Shadow, step: int) -> Fault:
    record, command = shadow.sense[0], shadow.command[0]
    values = ", ".join(f"{name} = {command[name]}" for name in OUTPUTS)
    scalars = {name: float(record[name]) for name in Sense._fields if name != "phase_currents"}
    currents = tuple(shadow.currents[: int(record["phase_count"])].tolist())
    sense = Sense(phase_currents=currents, **scalars)
    return Fault(
        FaultKind.INVALID_OUTPUT,
        f"the command is not finite: {values}",
        "step",
        step=step,
        time=sense.time,
        sense=sense._asdict(),
    )


def play_back(loaded: LoadedCandidate, request: tuple[Shadowing, int]) -> PlantState:
    """Find the plant's state at one step; this is what a worker process without a user's candidate does."""
    plan, step = request
    return plant_at(plan.path, plan.scenario, step, loaded.progress)
