"""The one form in which a candidate's process answers: a few numbers and, for a fault, bounded text.

It is written in a process that runs the candidate's code, so whatever stands in it is checked, and none of it is an
object: no pickle is ever read from there.
"""

import json
from dataclasses import dataclass
from enum import IntEnum
from struct import Struct
from struct import error as StructError
from typing import Any, Final, cast, get_args

from drivegate.candidates.fault import Fault, FaultKind, Phase, bounded_line, bounded_text
from drivegate.containment.orders import WORD

LONGEST_REPLY: Final = 2**17
"""Bytes of a reply at most."""
CHECK_BYTES: Final = 16
"""Bytes of the digest of what the plant in the candidate's process came to."""

_HEADER = Struct(f"=8sqqqqqq{CHECK_BYTES}s")
_FIELDS = ("kind", "message", "phase", "error", "traceback", "step")


class UnreadableReply(Exception):
    """What came from a candidate's process is no reply."""


class Ending(IntEnum):
    """How an order ended."""

    DONE = 0
    FAULT = 1
    REFUSED = 2
    BROKEN = 3


@dataclass(frozen=True)
class Reply:
    """How an order ended."""

    ending: Ending
    """The way."""
    status: int = 0
    """Status of the loop, of `drivegate_models.loop.exchange`."""
    steps: int = 0
    """Number of steps that were answered."""
    is_python: bool = False
    """Whether the instance is stepped by the Python interpreter."""
    state_size: int = 0
    """Bytes of a native instance's state; 0 if unknown."""
    most_instructions: int = 0
    """Greatest number of instructions of a step; 0 where nobody counts them."""
    check: bytes = bytes(CHECK_BYTES)
    """Digest of what the plant came to, of `CHECK_BYTES` bytes."""
    text: str = ""
    """A fault as `fault_text` writes it, a sentence for the user, or a traceback."""


def packed(reply: Reply) -> bytes:
    """Write a reply as bytes."""
    header = _HEADER.pack(
        WORD,
        reply.ending,
        reply.status,
        reply.steps,
        reply.is_python,
        reply.state_size,
        reply.most_instructions,
        reply.check,
    )
    return header + reply.text.encode(errors="replace")[: LONGEST_REPLY - len(header)]


def unpacked(message: bytes) -> Reply:
    """Read a reply; whatever is not one raises `UnreadableReply`."""
    try:
        word, ending, status, steps, is_python, state_size, instructions, check = _HEADER.unpack_from(message)
        if word != WORD or len(message) > LONGEST_REPLY or min(steps, state_size, instructions) < 0:
            raise UnreadableReply
        text = message[_HEADER.size :].decode(errors="replace")
        return Reply(Ending(ending), status, steps, bool(is_python), state_size, instructions, check, text)
    except (StructError, ValueError) as error:
        raise UnreadableReply from error


def fault_text(fault: Fault) -> str:
    """Write a fault as text; what was sensed then is known to the harness already."""
    return json.dumps({name: getattr(fault, name) for name in _FIELDS})


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
