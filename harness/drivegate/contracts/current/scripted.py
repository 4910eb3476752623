"""Steps of a controller through given Senses: its commands, or its fault."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.fault import CandidateFault, Fault, placed, refused_command
from drivegate.containment.candidate_process import Answered
from drivegate.containment.contained_controller import ContainedController
from drivegate.containment.messages import AnyController
from drivegate.containment.orders import GiveSenses
from drivegate_models.contract.current.records import COMMAND
from drivegate_models.contract.current.signals import Nameplate, Sense
from drivegate_models.loop.command_playing import rows_of
from drivegate_models.loop.exchange import COMPLETED, NOT_FINITE, OUTPUTS, STOPPED, Exchange, make_exchange
from drivegate_models.loop.given_steps import SCALARS, make_steps, senses_of

_ANGLE = OUTPUTS.index("advance_angle")


class GivenSteps:
    """A controller that is reset, and then stepped through Senses that are given in pieces.

    Attributes
    ----------
    last_answers : ndarray, shape (n, 3)
        Commands of the last piece up to a fault, `exchange.OUTPUTS` in each row.
    """

    def __init__(self, controller: AnyController, nameplate: Nameplate) -> None:
        self._controller = controller
        self._steps = 0
        self.last_answers: NDArray[np.float64] = np.empty((0, len(OUTPUTS)))
        self._exchange: Exchange | None = None
        self._nameplate = nameplate
        self.restart()

    def restart(self) -> None:
        """Reset the controller; the steps go on."""
        self._controller.reset(self._nameplate)
        if not isinstance(self._controller, ContainedController):
            self._exchange = make_exchange(
                self._nameplate.phases,
                step_address=self._controller.step_address,
                state_address=self._controller.state_address,
            )

    def answers(self, senses: NDArray[np.float64]) -> NDArray[np.float64]:
        """Make a step for each row of Senses, and give the commands, shape (n, 3); a fault is raised."""
        answered = self._made(np.ascontiguousarray(senses, np.float64))
        commands = answered.commands
        if answered.status == COMPLETED:
            self._steps += len(senses)
            return commands
        # A process that was killed behind its last step, or that miscounts them, has not failed behind the last Sense.
        row = min(len(commands) - (answered.status == NOT_FINITE), len(senses) - 1)
        self.last_answers = commands[:row]
        raise CandidateFault(_placed(answered, senses[row], self._steps + row))

    def _made(self, senses: NDArray[np.float64]) -> Answered:
        if isinstance(self._controller, ContainedController):
            answered = self._controller.answers(GiveSenses(senses))
            return replace(answered, commands=rows_of(answered.commands))
        assert self._exchange is not None, "a controller of this process has records here"
        kept = np.zeros(len(senses), COMMAND)
        status, count = make_steps(self._exchange._replace(kept=kept), senses)
        commands = rows_of(kept[: count + (status == NOT_FINITE)])
        return Answered(commands, int(status), b"", self._controller.fault if status == STOPPED else None)


def _placed(answered: Answered, row: NDArray[np.float64], step: int) -> Fault:
    """Add to what ended the steps where it happened."""
    numbers = row.tolist()
    scalars = dict(zip(SCALARS, numbers, strict=False))
    sense = Sense(phase_currents=tuple(numbers[len(SCALARS) :]), **scalars)
    fault = answered.fault
    if fault is None:
        command = np.zeros(1, COMMAND)
        if answered.status == NOT_FINITE:
            command[list(OUTPUTS)] = tuple(answered.commands[-1])
        finite = answered.status != NOT_FINITE
        return refused_command(command[0], finite=finite, step=step, sense=sense)
    return placed(fault, step, sense)


def scripted_angles(
    controller: AnyController, nameplate: Nameplate, signals: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Reset a controller, step it through given signals and collect its advance angles."""
    senses = senses_of(signals, nameplate.phases, nameplate.control_period)
    return GivenSteps(controller, nameplate).answers(senses)[:, _ANGLE]
