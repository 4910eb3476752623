"""An instance of a candidate in a process of its own, as those use it who judge its commands."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.controller import CompiledController
from drivegate.candidates.fault import Fault, FaultKind
from drivegate.candidates.kinds import COMPILED_FOLDER, KINDS
from drivegate.candidates.step_costs import NO_COSTS, StepCosts, greatest_costs
from drivegate.containment.candidate_process import Answered, CandidateProcess
from drivegate.containment.protocol import CloseLoop, GiveSenses, Reset, RunOrder
from drivegate.containment.serving import check_of
from drivegate_models.contract.current.signals import Nameplate
from drivegate_models.contract.duty.signals import DutyNameplate
from drivegate_models.loop.exchange import COMPLETED
from drivegate_models.loop.step_recording import player_of, playing_step


class CommandPlayer(CompiledController):
    """A controller that answers with given commands, whatever it senses."""

    def __init__(self, commands: NDArray[Any], fault: Fault | None = None) -> None:
        self._commands = np.ascontiguousarray(commands)
        super().__init__(playing_step(), player_of(self._commands))
        self._fault = fault

    @property
    def fault(self) -> Fault | None:
        return self._fault

    def reset(self, _nameplate: Nameplate | DutyNameplate) -> None:
        """Go on: the commands are those of the whole run, with its restarts."""


class PlayedCommands(CommandPlayer):
    """The answers of a contained instance, played back; the plant that they drive is the judge's own."""

    def __init__(self, answered: Answered) -> None:
        super().__init__(answered.commands, answered.fault)
        self._answered = answered

    def disturbed(self, records: Any) -> Fault | None:
        """Compare the records of a finished run with the plant's results in the candidate's process."""
        if self._answered.status == COMPLETED and check_of(records) == self._answered.check:
            return None
        return Fault(
            FaultKind.MEMORY,
            "the same commands, played back, end in another state of the plant than in the candidate's process; "
            "the candidate writes into memory that is not its own",
            "step",
        )


class ContainedController:
    """One instance of a candidate in its process; after a crash the next run makes a new one.

    `is_python`: whether it is stepped by the Python interpreter. `state_size`: bytes of its state, where it is native;
    otherwise 0.
    """

    def __init__(self, process: CandidateProcess) -> None:
        self._process = process
        made = process.made_instance()
        self._generation = process.generation
        self.is_python = made.is_python
        self.state_size = made.state_size
        self._costs = NO_COSTS
        self.remarks: tuple[str, ...] = ()
        """What its process has warned of by the end of the last run."""

    @property
    def is_compiled(self) -> bool:
        """Whether its steps are compiled code of this processor, which takes little time for many of them."""
        return not self.is_python and KINDS[self._process.candidate.kind].folder == COMPILED_FOLDER

    def reset(self, nameplate: Nameplate | DutyNameplate) -> None:
        if self._generation != self._process.generation or not self._process.is_running:
            self._process.made_instance()
            self._generation = self._process.generation
        self._process.carried_out(Reset(nameplate))

    def run(self, order: CloseLoop, steps: int) -> PlayedCommands:
        """Run the instance, already reset, in closed loop, and return its commands for being played back."""
        return PlayedCommands(self._answered(order, steps))

    def answers(self, order: GiveSenses) -> Answered:
        """Step the instance through given Senses, which follow on those since the reset."""
        return self._answered(order, len(order.senses))

    def _answered(self, order: RunOrder, steps: int) -> Answered:
        answered = self._process.answered(order, steps)
        self._costs = greatest_costs((self._costs, answered.costs))
        self.remarks = answered.remarks
        return answered

    def taken_costs(self) -> StepCosts:
        """Return the greatest costs of a step on an emulated target since they were last taken."""
        costs, self._costs = self._costs, NO_COSTS
        return costs
