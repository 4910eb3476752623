"""The parts of such a comparison: what one candidate sensed and answered in a run, and what the other answers to it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.controller import show_drive
from drivegate.candidates.fault import Fault, FaultKind, placed
from drivegate.candidates.python.bridge import PythonController
from drivegate.containment.candidate_process import Answered
from drivegate.containment.contained_controller import ContainedController
from drivegate.containment.messages import AnyController, JudgedCandidate
from drivegate.containment.orders import GiveDutySenses
from drivegate.contracts.duty.plant_run import duty_run
from drivegate.contracts.duty.run import DUTY_RATIOS, LEGS, DutyClosedLoopRun, duty_nameplate, refusal_of
from drivegate.drives.kinds import kind_of
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.contract.duty.records import DUTY_COMMAND, DUTY_SENSE
from drivegate_models.contract.duty.signals import DutyCommand, DutySense
from drivegate_models.errors import HarnessFault
from drivegate_models.loop.exchange import COMPLETED, STOPPED
from drivegate_models.loop.given_duty_steps import given_duty_steps, make_duty_steps

FIELDS: Final = tuple(name for name in DUTY_COMMAND.names or () if name != "struct_size")
"""Fields of a command that are compared."""
BLOCK: Final = 10_000
"""Steps that are answered at once."""
_ESTIMATES: Final = ("torque", "angle", "speed", "input_power")


@dataclass(frozen=True)
class DrivenRun:
    """A run of the candidate that drives the plant."""

    run: DutyClosedLoopRun
    """Trace and commands."""
    senses: NDArray[Any]
    """What was sensed in each step, but for the addresses of the phase currents, shape (n,)."""
    currents: NDArray[np.float64]
    """These (A), shape (n, 3)."""

    def sense(self, step: int) -> DutySense:
        """Give what was sensed in a step."""
        row = self.senses[step]
        scalars = {name: row[name].item() for name in DutySense._fields if name != "phase_currents"}
        first, second, third = self.currents[step].tolist()
        return DutySense(phase_currents=(first, second, third), **scalars)


@dataclass(frozen=True)
class AnswerRequest:
    """What the second candidate is to answer."""

    scenario: Scenario
    """The scenario."""
    driven: DrivenRun
    """The run whose Senses it is given."""
    again: bool = False
    """Whether the instance has run the scenario once before, and was reset."""


@dataclass(frozen=True)
class DutyAnswers:
    """How the second candidate answered."""

    commands: NDArray[Any]
    """Its commands, up to a fault, shape (n,)."""
    fault: Fault | None
    """What ended them."""


def drive_run(loaded: JudgedCandidate, scenario: Scenario) -> DrivenRun:
    """Run a candidate, and play its commands back to see what was sensed."""
    run = duty_run(kind_of(scenario.drive).prepare_loop(), scenario, loaded.controller())
    playback = _Playback(run.commands)
    again = duty_run(kind_of(scenario.drive).prepare_loop(), scenario, PythonController(playback))
    if not np.array_equal(run.trace, again.trace, equal_nan=True):
        raise HarnessFault("the recorded commands come to another run when they are played back")
    return DrivenRun(run, playback.senses, playback.currents)


class _Playback:
    """Gives recorded commands again, and keeps what is sensed."""

    def __init__(self, commands: NDArray[Any]) -> None:
        self._commands = commands
        self.senses = np.zeros(len(commands), DUTY_SENSE)
        self.currents = np.zeros((len(commands), 3))

    def reset(self, _nameplate: Any) -> None:
        """Begin at the first command."""
        self._rows: Iterator[int] = iter(range(len(self._commands)))

    def step(self, sense: DutySense) -> DutyCommand:
        """Give the next command."""
        row = next(self._rows)
        self.currents[row] = sense.phase_currents
        kept = self.senses[row]
        for name in DutySense._fields:
            if name != "phase_currents":
                kept[name] = getattr(sense, name)
        command = self._commands[row]
        first, second, third = (float(command[name]) for name in DUTY_RATIOS)
        legs = (int(command[LEGS[0]]), int(command[LEGS[1]]), int(command[LEGS[2]]))
        return DutyCommand(
            (first, second, third),
            legs,
            float(command["next_period"]),
            **{name: float(command[name]) for name in _ESTIMATES},
            fault=int(command["fault"]),
        )


def answer_run(loaded: JudgedCandidate, request: AnswerRequest) -> DutyAnswers:
    """Give a candidate what another one sensed, in blocks, until it ends or has a fault."""
    driven, nameplate = request.driven, duty_nameplate(request.scenario)
    controller = loaded.controller()
    if request.again:
        duty_run(kind_of(request.scenario.drive).prepare_loop(), request.scenario, controller)
    show_drive(controller, request.scenario.drive)
    controller.reset(nameplate)
    kept: list[NDArray[Any]] = [np.zeros(0, DUTY_COMMAND)]
    for begin in range(0, len(driven.senses), BLOCK):
        rows = slice(begin, begin + BLOCK)
        answered = _answered(controller, driven.senses[rows], driven.currents[rows])
        if answered.status != COMPLETED:
            # A process that was killed behind its last step has not failed behind the last Sense.
            valid = min(len(answered.commands) - _is_wrong(answered.status), len(driven.senses[rows]) - 1)
            kept.append(answered.commands[:valid])
            return DutyAnswers(np.concatenate(kept), _placed(answered, driven, begin + valid))
        kept.append(answered.commands)
    return DutyAnswers(np.concatenate(kept), None)


def _answered(controller: AnyController, senses: NDArray[Any], currents: NDArray[np.float64]) -> Answered:
    if isinstance(controller, ContainedController):
        return controller.answers(GiveDutySenses(senses, currents))
    kept = np.zeros(len(senses), DUTY_COMMAND)
    steps = given_duty_steps(controller.step_address, controller.state_address, senses, currents, kept=kept)
    status, count = make_duty_steps(steps)
    fault = controller.fault if status == STOPPED else None
    return Answered(kept[: count + _is_wrong(status)], int(status), b"", fault)


def _is_wrong(status: int) -> bool:
    """Tell whether the last command is what is wrong."""
    return status not in (COMPLETED, STOPPED)


def _placed(answered: Answered, driven: DrivenRun, step: int) -> Fault:
    """Tell what ended the answers, and where."""
    sense = driven.sense(step)
    if answered.fault is not None:
        return placed(answered.fault, step, sense)
    message = refusal_of(answered.commands[-1] if _is_wrong(answered.status) else None, answered.status)
    return Fault(FaultKind.INVALID_OUTPUT, message, "step", step=step, time=sense.time, sense=sense._asdict())
