"""Failures in one place: whatever ends a command, as one sentence, an exit code and a document."""

from __future__ import annotations

import errno
import os
import sys
import traceback
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Any, Final

import click

from drivegate.output.streams import leave_unread, write_to
from drivegate_cases.documents.system_failure import refusal_by_system
from drivegate_cases.documents.wording import LONGEST_MESSAGE, one_line, short_line, shortened
from drivegate_models.errors import HarnessFault, InputError, OutOfMemory

DEBUG_VARIABLE: Final = "DRIVEGATE_DEBUG"
"""Environment variable that adds the traceback to the sentence of a failure when it is 1."""

ERROR_SCHEMA: Final = 1
"""Version of the document that reports an error."""


class ExitCode(IntEnum):
    """What the process reports to a script."""

    PASSED = 0
    FAILED = 1
    REFUSED = 2
    HARNESS_FAULT = 3
    INTERRUPTED = 130


@dataclass(frozen=True)
class Failure:
    """Why a command ended without an outcome."""

    message: str
    """One sentence on one line; what exceeds `LONGEST_MESSAGE` is left out in its middle, between place and
    remedy."""
    exit_code: int

    def __post_init__(self) -> None:
        """Shorten the message, whoever wrote it."""
        object.__setattr__(self, "message", shortened(self.message, LONGEST_MESSAGE))

    def document(self) -> dict[str, Any]:
        return {"schema": ERROR_SCHEMA, "error": {"message": self.message, "exit_code": int(self.exit_code)}}

    def about(self, name: str) -> Failure:
        """Return the failure with what it is about in front."""
        return replace(self, message=f"{short_line(name)}: {self.message}")


def failure_of(error: BaseException) -> Failure:
    """Turn whatever ended a command into a sentence and an exit code."""
    if isinstance(error, InputError):
        return Failure(_sentence(str(error)), ExitCode.REFUSED)
    if isinstance(error, click.ClickException):
        return Failure(_sentence(error.format_message()), ExitCode.REFUSED)
    if isinstance(error, KeyboardInterrupt) or isinstance(error.__cause__, KeyboardInterrupt):
        return Failure("interrupted", ExitCode.INTERRUPTED)
    lack = _lack_of_memory(error)
    if lack is not None:
        return Failure(_sentence(lack), ExitCode.HARNESS_FAULT)
    refusal = refusal_by_system(error)
    if refusal is not None:
        return Failure(_sentence(refusal), ExitCode.REFUSED)
    text = str(error) if isinstance(error, HarnessFault) else f"{type(error).__name__}: {error}"
    return Failure(
        _sentence(
            f"drivegate itself failed, which is no verdict on a candidate: {_ends(text)}; "
            f"with {DEBUG_VARIABLE}=1 it prints where"
        ),
        ExitCode.HARNESS_FAULT,
    )


def _lack_of_memory(error: BaseException) -> str | None:
    """Return a sentence if an error shows that the machine has too little memory."""
    if isinstance(error, OutOfMemory):
        return str(error)
    if not isinstance(error, MemoryError) and not (
        isinstance(error, OSError) and error.errno == errno.ENOMEM
    ):
        return None
    # It brings what measures processes, which commands that succeed do not need.
    from drivegate.containment.machine_memory import lack_of_memory

    return str(lack_of_memory("an allocation of drivegate's own was refused"))


def complain(failure: Failure, error: BaseException | None = None) -> None:
    """Print a failure on standard error."""
    shown = error is not None and os.environ.get(DEBUG_VARIABLE) == "1"
    details = "".join(traceback.format_exception(error)) if shown else ""
    try:
        write_to(sys.stderr, f"{details}error: {failure.message}\n")
    except OSError:
        # A terminal that has gone, or a full disk: the exit code says the same.
        leave_unread(sys.stderr)


def _ends(text: str) -> str:
    """Keep the first and the last line of a text: of a traceback, what failed and how."""
    lines = text.replace("Traceback (most recent call last):", "").splitlines()
    parts = [line.strip().rstrip(":") for line in lines if line.strip()] or [""]
    return parts[0] if len(parts) == 1 else f"{parts[0]}: {parts[-1]}"


def _sentence(text: str) -> str:
    return one_line(" ".join(text.split())).removesuffix(".")
