"""A candidate's fault: the verdict on a controller that did not answer as the contract requires.

Everything in it is bounded text and numbers, whatever the candidate raised, printed or returned.
"""

import re
import signal
import traceback
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any, Final, Literal

from drivegate_cases.documents.wording import one_line
from drivegate_models.contract.current.signals import Sense
from drivegate_models.contract.duty.signals import DutySense

Phase = Literal["loading", "reset", "step"]

LONGEST_MESSAGE = 2_000
LONGEST_TRACEBACK = 20_000

OVERWRITTEN_SIZE: Final = (
    "the command's struct_size was overwritten with a negative number; "
    "the harness sets it, leave it unchanged"
)
UNSENSED: Final = "; this drive has no position sensor, so angle and speed are NaN"
"""What explains an output that is not finite where nothing shows the shaft."""
_ADDRESS = re.compile(r"\b0x[0-9a-fA-F]{6,}\b")
_CALLERS = ("drivegate", "importlib", "_frozen_importlib", "_frozen_importlib_external")
_CUT = "\n[...]\n"


class FaultKind(StrEnum):
    """The ways in which a candidate fails to answer; none of them can be waived."""

    EXCEPTION = "exception"
    INVALID_OUTPUT = "invalid output"
    CRASH = "crash"
    HANG = "hang"
    NON_DETERMINISTIC = "non-deterministic"
    MEMORY = "foreign memory"
    SANITIZER = "sanitizer report"
    BUILDS = "different builds"


@dataclass(frozen=True)
class Fault:
    """What happened, when, and what the candidate had sensed then."""

    kind: FaultKind
    message: str
    """One line of at most `LONGEST_MESSAGE` characters."""
    phase: Phase
    error: str = ""
    """Name of the exception's class or of the signal; empty where there is neither."""
    traceback: str = ""
    """The candidate's own part of the traceback, or what a dying process printed, of at most
    `LONGEST_TRACEBACK` characters."""
    step: int | None = None
    """Number of steps that the run had completed before, when the phase is a step."""
    time: float | None = None
    """Time of that step (s, simulated)."""
    sense: Mapping[str, float | tuple[float, ...]] | None = None
    """The Sense of that step, by field name."""
    scenario: Mapping[str, Any] | None = None
    """The scenario in which it happened, as plain data; None outside of a run."""


class CandidateFault(Exception):
    """Raised to end a job with a verdict on the candidate."""

    def __init__(self, fault: Fault) -> None:
        super().__init__(fault)
        self.fault = fault


def exception_fault(error: BaseException, phase: Phase) -> Fault:
    name = type(error).__name__
    # The candidate's own class writes the text, and may raise anything in doing so.
    try:
        text, trace = str(error), _traceback_of(error)
    except BaseException as unprintable:
        text, trace = f"(its text cannot be had: {type(unprintable).__name__})", ""
    message = bounded_line(f"{name}: {text}" if text else name)
    return Fault(FaultKind.EXCEPTION, message, phase, error=name, traceback=trace)


def refused_command(message: str, step: int, sense: Sense | DutySense) -> Fault:
    """Describe a command at which a run ended although the controller itself reports no fault."""
    return Fault(FaultKind.INVALID_OUTPUT, message, "step", step=step, time=sense.time, sense=sense._asdict())


def placed(fault: Fault, step: int, sense: Sense | DutySense) -> Fault:
    """Add to a fault where in a run it happened, unless that was before the first step."""
    if fault.phase != "step":
        return fault
    return replace(fault, step=step, time=sense.time, sense=sense._asdict())


def bounded_line(text: str, longest: int = LONGEST_MESSAGE) -> str:
    """Fit any text into one printable line.

    Memory addresses are left out, since they differ from run to run.
    """
    # Cut first: the text is the candidate's and may have any length. One character more shows that it was longer.
    line = _without_addresses(one_line(text[: LONGEST_MESSAGE + 1]))
    return line if len(line) <= longest else line[: longest - 1] + "…"


def bounded_reason(text: str) -> str:
    """Fit what a compiler reports into one short line, since more text follows it in the sentence."""
    return bounded_line(text.strip(), 300)


def short_lines(text: str) -> str:
    """Cut lines of any length, for patterns whose time grows with the square of it."""
    return "\n".join(line[:LONGEST_MESSAGE] for line in text.splitlines())


def bounded_text(text: str) -> str:
    """Fit any text into a bounded number of printable lines; the middle of a longer one is left out.

    Memory addresses are left out too, since they differ from run to run.
    """
    lines = _without_middle(text).replace("\t", "    ").split("\n")
    return _without_middle(_without_addresses("\n".join(map(one_line, lines))))


def _without_middle(text: str) -> str:
    half = (LONGEST_TRACEBACK - len(_CUT)) // 2
    return text if len(text) <= LONGEST_TRACEBACK else text[:half] + _CUT + text[-half:]


def _without_addresses(text: str) -> str:
    return _ADDRESS.sub("0x…", text)


def _traceback_of(error: BaseException) -> str:
    """Format from the candidate's own first frame on: those that called it say nothing about it."""
    frames = error.__traceback__
    while frames is not None and frames.tb_frame.f_globals.get("__name__", "").split(".")[0] in _CALLERS:
        frames = frames.tb_next
    return bounded_text("".join(traceback.format_exception(type(error), error, frames)))


def ending_in_words(status: int) -> tuple[str, str]:
    """State how a process ended."""
    if status >= 0:
        return f"ended itself with exit status {status}", ""
    try:
        name = signal.Signals(-status).name
    except ValueError:
        name = f"signal {-status}"
    return f"was killed by {name} ({signal.strsignal(-status) or 'unknown'})", name
