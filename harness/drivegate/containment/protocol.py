"""What a judge orders a candidate's process to do, and the one form in which that process replies.

Orders go from the harness to the candidate, never the other way: what comes back is a `Reply` and commands.
None of them holds a scenario, a seed, or a limit that is judged.

A reply is written in a process that runs the candidate's code, so all of it is checked, and none of it is an object:
no pickle is ever read from there.
"""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import IntEnum
from struct import Struct
from struct import error as StructError
from typing import Any, Final, TypeAlias, cast, get_args

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import Fault, FaultKind, Phase, bounded_line, bounded_reason, bounded_text
from drivegate.candidates.step_costs import NO_COSTS, StepCosts
from drivegate_models.contract.current.signals import Nameplate
from drivegate_models.contract.duty.signals import DutyNameplate
from drivegate_models.contract.layout import CURRENT, LAYOUTS, Layout
from drivegate_models.loop.loop_inputs import LoopInputs

MOST_REMARKS: Final = 20
"""Number of remarks of a run that are read."""
PACKET: Final = Struct("=8sqq")
"""A word that says whose it is, the number of bytes of the order, which lies in the shared memory, and that of the
memory itself. A memory that is new is included as a file descriptor."""
WORD: Final = b"drivegat"
"""First bytes of every packet, either way."""
# A fault with a traceback of 20 000 characters fits, even if JSON escapes many of them with six bytes each.
LONGEST_REPLY: Final = 2**17
"""Bytes of a reply at most."""
CHECK_BYTES: Final = 16
"""Bytes of the digest of the plant's results in the candidate's process."""

_HEADER = Struct(f"=8sqqqqqqqq{CHECK_BYTES}s")
_FIELDS = ("kind", "message", "phase", "error", "traceback", "step")


@dataclass(frozen=True)
class Setup:
    """Take a candidate in hand, without running any of its code."""

    candidate: Candidate
    memory_limit: int
    """Bytes that the process may allocate beyond what it has at its start."""


@dataclass(frozen=True)
class MakeInstance:
    """Make a new instance of the candidate, and delete the previous one."""


@dataclass(frozen=True)
class Reset:
    nameplate: Nameplate | DutyNameplate


@dataclass(frozen=True)
class CloseLoop:
    """Close the loop between the instance and a plant, and keep the commands."""

    prepare: Callable[..., Any]
    """A module's function that makes the run ready, `drivegate_models.loop.closed_loop.prepared_loop` of a
    drive or `drivegate_models.pm_ac.closed_loop.prepared_duty_loop`."""
    inputs: LoopInputs
    """What the run is made of, without what is observed of it."""
    restart_steps: Sequence[int] = ()
    """Steps before which the instance is reset, in the process that has it."""
    layout: Layout = CURRENT
    """Records of the contract."""
    steps_before: int = 0
    """Number of steps before those whose commands are kept."""

    @property
    def commands(self) -> np.dtype[Any]:
        """Layout of the commands that are kept."""
        return self.layout.command


@dataclass(frozen=True)
class GiveSenses:
    """Step the instance through given Senses, which follow on those given since the reset, and keep the commands."""

    senses: NDArray[Any]
    """One for each step, as records of the contract, shape (n,)."""
    currents: NDArray[np.float64]
    """Their phase currents (A), shape (n, m)."""

    @property
    def commands(self) -> np.dtype[Any]:
        """Layout of the commands that are kept."""
        return LAYOUTS[self.senses.dtype].command


RunOrder: TypeAlias = CloseLoop | GiveSenses
"""What is answered with commands."""

Order: TypeAlias = Setup | MakeInstance | Reset | RunOrder


class UnreadableReply(Exception):
    """What came from a candidate's process is no reply."""


class Ending(IntEnum):
    DONE = 0
    FAULT = 1
    REFUSED = 2
    BROKEN = 3


@dataclass(frozen=True)
class Reply:
    """How an order ended."""

    ending: Ending
    status: int = 0
    """Status of the loop, of `drivegate_models.loop.exchange`."""
    steps: int = 0
    """Number of steps that were answered."""
    is_python: bool = False
    """Whether the instance is stepped by the Python interpreter."""
    state_size: int = 0
    """Bytes of a native instance's state; 0 if unknown."""
    costs: StepCosts = NO_COSTS
    """Greatest costs of a step on an emulated target."""
    check: bytes = bytes(CHECK_BYTES)
    """Digest of the plant's results, of `CHECK_BYTES` bytes."""
    text: str = ""
    """A fault as `fault_text` writes it, a sentence for the user, a traceback, or of a run that is done, its remarks
    as `remarks_text` writes them."""


def packed(reply: Reply) -> bytes:
    header = _HEADER.pack(
        WORD,
        reply.ending,
        reply.status,
        reply.steps,
        reply.is_python,
        reply.state_size,
        *reply.costs,
        reply.check,
    )
    return header + reply.text.encode(errors="replace")[: LONGEST_REPLY - len(header)]


def unpacked(message: bytes) -> Reply:
    """Read a reply; whatever is not one raises `UnreadableReply`."""
    try:
        word, ending, status, steps, is_python, state_size, *costs, check = _HEADER.unpack_from(message)
        if word != WORD or len(message) > LONGEST_REPLY or min(steps, state_size, *costs) < 0:
            raise UnreadableReply
        text = message[_HEADER.size :].decode(errors="replace")
        return Reply(
            Ending(ending), status, steps, bool(is_python), state_size, StepCosts(*costs), check, text
        )
    except (StructError, ValueError) as error:
        raise UnreadableReply from error


def fault_text(fault: Fault) -> str:
    """Write a fault as text; what was sensed then is known to the harness already."""
    return json.dumps({name: getattr(fault, name) for name in _FIELDS})


def remarks_text(remarks: Sequence[str]) -> str:
    """Write what a process has warned of."""
    return json.dumps(list(remarks)) if remarks else ""


def remarks_of(text: str) -> tuple[str, ...]:
    """Read remarks, all of them bounded and printable; text that is none raises `UnreadableReply`."""
    try:
        lines: Any = json.loads(text or "[]")
    except (ValueError, RecursionError) as error:
        raise UnreadableReply from error
    if not isinstance(lines, list) or not all(isinstance(line, str) for line in lines):
        raise UnreadableReply
    return tuple(bounded_reason(line) for line in lines[:MOST_REMARKS])


def fault_of(text: str) -> Fault:
    """Read a fault, all of it bounded and printable; text that is none raises `UnreadableReply`."""
    try:
        fields: Any = json.loads(text)
        values = [fields[name] for name in _FIELDS]
    except (ValueError, RecursionError, LookupError, TypeError) as error:
        raise UnreadableReply from error
    kind, message, phase, error_name, traceback, step = values
    texts = (kind, message, phase, error_name, traceback)
    if not all(isinstance(value, str) for value in texts) or phase not in get_args(Phase):
        raise UnreadableReply
    if kind not in list(FaultKind) or not (step is None or (type(step) is int and 0 <= step < 2**62)):
        raise UnreadableReply
    return Fault(
        FaultKind(kind),
        bounded_line(message),
        cast("Phase", phase),
        error=bounded_line(error_name),
        traceback=bounded_text(traceback),
        step=step,
    )
