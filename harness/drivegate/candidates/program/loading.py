"""Loading a candidate that is a program: starting it and shaking hands; each instance is a process of its own."""

from collections.abc import Callable
from pathlib import Path
from typing import Final, TypeVar

from drivegate.candidates.candidate import Candidate, Program
from drivegate.candidates.contract import AnyNameplate
from drivegate.candidates.fault import CandidateFault, Fault, FaultKind, Phase, bounded_line
from drivegate.candidates.program.process import LateAnswer, ProgramEnded, ProgramProcess
from drivegate.candidates.program.protocol import (
    HELLO,
    WrongAnswer,
    check_hello,
    check_ready,
    command_of,
    duty_command_of,
    duty_sense_message,
    reset_message,
    sense_message,
)
from drivegate.candidates.python.bridge import PythonController
from drivegate_cases.documents.wording import one_line
from drivegate_models.contract.current.signals import Command, Sense
from drivegate_models.contract.duty.signals import DutyCommand, DutySense
from drivegate_models.errors import HarnessFault

START_DEADLINE: Final = 30.0
"""Time that a program has for its first answer, and for each reset (s)."""

_Answer = TypeVar("_Answer")


def load_controller(candidate: Candidate) -> PythonController:
    """Start a candidate's program and shake hands with it."""
    if not isinstance(candidate.details, Program):
        raise HarnessFault(f"the candidate '{one_line(candidate.name)}' is no program")
    return PythonController(ExecutedProgram(candidate.details, candidate.folder))


class ExecutedProgram:
    """A program with the methods of a Python candidate."""

    def __init__(self, program: Program, folder: Path) -> None:
        self._process = ProgramProcess(program, folder)
        self._step_deadline = program.step_deadline
        try:
            self._answered(HELLO, check_hello, START_DEADLINE, "loading")
        except BaseException:
            self._process.end()
            raise

    def reset(self, nameplate: AnyNameplate) -> None:
        """Send the nameplate."""
        self._answered(reset_message(nameplate), check_ready, START_DEADLINE, "reset")

    def step(self, sense: Sense | DutySense) -> Command | DutyCommand:
        """Send a Sense and take the Command that answers it."""
        if isinstance(sense, DutySense):
            return self._answered(duty_sense_message(sense), duty_command_of, self._step_deadline, "step")
        return self._answered(sense_message(sense), command_of, self._step_deadline, "step")

    def _answered(
        self, message: bytes, read: Callable[[bytes], _Answer], deadline: float, phase: Phase
    ) -> _Answer:
        try:
            return read(self._process.request(message, deadline))
        except WrongAnswer as error:
            fault = Fault(FaultKind.INVALID_OUTPUT, bounded_line(str(error)), phase)
        except LateAnswer as error:
            fault = Fault(FaultKind.HANG, bounded_line(str(error)), phase)
        except ProgramEnded as error:
            fault = Fault(FaultKind.CRASH, bounded_line(str(error)), phase, error=error.signal_name)
        raise CandidateFault(fault)
