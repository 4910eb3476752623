"""Loading a candidate that is a program: each instance is a process, with one line to it and one line back."""

import os
import select
import signal
import subprocess
import time
import weakref
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Final, TypeVar

from drivegate.candidates.candidate import Candidate, Program
from drivegate.candidates.contract import AnyNameplate
from drivegate.candidates.fault import CandidateFault, Fault, FaultKind, Phase, bounded_line, ending_in_words
from drivegate.candidates.program.protocol import (
    HELLO,
    LONGEST_LINE,
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
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.contract.current.signals import Command, Sense
from drivegate_models.contract.duty.signals import DutyCommand, DutySense
from drivegate_models.errors import HarnessFault, InputError

# For a program that ends by itself once its input is closed. It is killed after that time, so little is lost.
_PATIENCE = 0.25
# After a line too many each answer is that of the request before, and may come after every look that does not wait.
_LOOKS_EVERY = 4096
_LOOKS_MS = 20.0
START_DEADLINE: Final = 30.0
"""Time that a program has for its first answer, and for each reset (s)."""

_Answer = TypeVar("_Answer")


class NoAnswer(Exception):
    """The program was late, or has ended by itself."""

    def __init__(self, kind: FaultKind, sentence: str, signal_name: str = "") -> None:
        super().__init__(sentence)
        self.kind = kind
        self.signal_name = signal_name


class ProgramProcess:
    """A program that has been started, in a process group of its own; it ends with this object.

    Its standard error is that of this process. It inherits no other descriptor.
    """

    def __init__(self, program: Program, folder: Path) -> None:
        try:
            process = subprocess.Popen(
                program.arguments,
                executable=program.executable,
                cwd=folder,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                bufsize=0,
                # One signal then ends the program with all that it has started.
                process_group=0,
            )
        except OSError as error:
            raise InputError(
                f"the program {shown_path(program.executable)} cannot be started: {error.strerror}; "
                "it must be executable, and a script must begin with #! and its interpreter"
            ) from error
        assert process.stdin is not None
        assert process.stdout is not None
        self._process = process
        self._to, self._from = process.stdin.fileno(), process.stdout.fileno()
        # A program that does not read must not block the write; `request` reports it.
        os.set_blocking(self._to, False)
        os.set_blocking(self._from, False)
        self._requests = 0
        self._news = select.poll()
        self._news.register(self._from, select.POLLIN)
        self.end = weakref.finalize(self, _end, os.getpid(), process)

    def request(self, message: bytes, deadline: float) -> bytes:
        """Send one line and wait for the line that answers it."""
        if self._news.poll(_LOOKS_MS if self._looks_longer() else 0.0):
            if not os.read(self._from, 1):
                self._raise_ended("closed its standard output", b"")
            raise WrongAnswer("the program wrote a line that was not requested")
        try:
            sent = os.write(self._to, message)
        except BrokenPipeError:
            self._raise_ended("closed its standard input", b"")
        except BlockingIOError:
            sent = 0
        if sent < len(message):
            raise WrongAnswer("the program does not read its standard input")
        until = time.monotonic() + deadline
        answer = self._block(deadline, b"", deadline)
        while answer[-1:] != b"\n":
            answer += self._block(until - time.monotonic(), answer, deadline)
        if answer.find(b"\n") != len(answer) - 1:
            raise WrongAnswer("the program answered with more than one line")
        return answer

    def _block(self, patience: float, before: bytes, deadline: float) -> bytes:
        if patience <= 0 or not self._news.poll(1000.0 * patience):
            if self._process.poll() is not None:
                # Another process keeps its standard output open.
                self._raise_ended("", before)
            what = "wrote only a part of a line" if before else "gave no answer"
            raise NoAnswer(FaultKind.HANG, f"the program {what} within {deadline:g} s")
        block = os.read(self._from, LONGEST_LINE)
        if not block:
            self._raise_ended("closed its standard output", before)
        if len(before) + len(block) > LONGEST_LINE or (
            b"\n" not in block and len(before) + len(block) == LONGEST_LINE
        ):
            raise WrongAnswer(f"the answer is longer than {LONGEST_LINE} bytes")
        return block

    def _looks_longer(self) -> bool:
        """Count a request, and return whether to wait before it: often at first, then now and then."""
        number = self._requests
        self._requests += 1
        return number > 0 and (number & (number - 1) == 0 or number % _LOOKS_EVERY == 0)

    def _raise_ended(self, otherwise: str, before: bytes) -> None:
        """State how the program ended; one that only closed its streams goes on for some time, or for ever."""
        where = " in the middle of a line" if before else ""
        try:
            status = self._process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            raise WrongAnswer(f"the program {otherwise}{where}") from None
        predicate, signal_name = ending_in_words(status)
        raise NoAnswer(FaultKind.CRASH, f"the program {predicate}{where}", signal_name)


def _end(owner: int, process: "subprocess.Popen[bytes]") -> None:
    """Let the program see the end of its input, then kill it and its process group."""
    # A copy of this process has the object too, but the program is not its own to end.
    if os.getpid() != owner:
        return
    for stream in (process.stdin, process.stdout):
        if stream is not None:
            stream.close()
    with suppress(subprocess.TimeoutExpired):
        process.wait(_PATIENCE)
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def load_controller(candidate: Candidate) -> PythonController:
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
        self._answered(reset_message(nameplate), check_ready, START_DEADLINE, "reset")

    def step(self, sense: Sense | DutySense) -> Command | DutyCommand:
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
        except NoAnswer as error:
            fault = Fault(error.kind, bounded_line(str(error)), phase, error=error.signal_name)
        raise CandidateFault(fault)
