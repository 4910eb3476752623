"""How every command ends: what it prints, as text or as JSON, and the exit code, whatever happens in it."""

from __future__ import annotations

import errno
import json
import os
import sys
import traceback
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Any, Final, TextIO

import click

from drivegate_cases.documents.wording import one_line
from drivegate_models.errors import HarnessFault, InputError

if TYPE_CHECKING:
    from rich.console import Console

DEBUG_VARIABLE: Final = "DRIVEGATE_DEBUG"
"""Environment variable that adds the traceback to the sentence of a failure when it is 1."""

ERROR_SCHEMA: Final = 1
"""Version of the document that tells an error."""


class ExitCode(IntEnum):
    """What the process tells a script."""

    PASSED = 0
    FAILED = 1
    REFUSED = 2
    HARNESS_FAULT = 3
    INTERRUPTED = 130


@dataclass(frozen=True)
class Outcome:
    """What a command has come to.

    Attributes
    ----------
    document : mapping
        What ``--json`` prints; a number that is not finite becomes null.
    show : callable
        Prints the same for people.
    exit_code : int
        The exit code.
    """

    document: Mapping[str, Any]
    show: Callable[[Console], None]
    exit_code: int = ExitCode.PASSED


@dataclass(frozen=True)
class Failure:
    """Why a command came to nothing.

    Attributes
    ----------
    message : str
        One sentence on one line.
    exit_code : int
        The exit code.
    """

    message: str
    exit_code: int

    def document(self) -> dict[str, Any]:
        """Write the failure as plain data."""
        return {"schema": ERROR_SCHEMA, "error": {"message": self.message, "exit_code": int(self.exit_code)}}


def wants_json(words: Sequence[str]) -> bool:
    """Tell whether the arguments ask for JSON, even if they are wrong otherwise."""
    options = words[: words.index("--")] if "--" in words else words
    return "--json" in options


def conducted(work: Callable[[], object], *, as_json: bool) -> int:
    """Run a command to its end."""
    for stream in (sys.stdout, sys.stderr):
        # A console that cannot show a character is no reason to fail.
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    try:
        outcome = work()
        if not isinstance(outcome, Outcome):
            return outcome if isinstance(outcome, int) else ExitCode.PASSED
        _print(outcome, as_json)
    except (Exception, KeyboardInterrupt) as error:
        return _ended_by(error, as_json)
    return outcome.exit_code


def failure_of(error: BaseException) -> Failure:
    """Turn whatever ended a command into a sentence and an exit code."""
    if isinstance(error, InputError):
        return Failure(_sentence(str(error)), ExitCode.REFUSED)
    if isinstance(error, click.ClickException):
        return Failure(_sentence(error.format_message()), ExitCode.REFUSED)
    if isinstance(error, KeyboardInterrupt) or isinstance(error.__cause__, KeyboardInterrupt):
        return Failure("interrupted", ExitCode.INTERRUPTED)
    if isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EIO):
        place = f" at {error.filename}" if error.filename else ""
        return Failure(_sentence(f"cannot write{place}: {error.strerror}"), ExitCode.HARNESS_FAULT)
    text = str(error) if isinstance(error, HarnessFault) else f"{type(error).__name__}: {error}"
    return Failure(
        _sentence(
            f"drivegate itself failed, which is no verdict on a candidate: {_ends(text)}; "
            f"with {DEBUG_VARIABLE}=1 it tells where"
        ),
        ExitCode.HARNESS_FAULT,
    )


def complain(failure: Failure, error: BaseException | None = None) -> None:
    """Tell a failure on standard error."""
    if error is not None and os.environ.get(DEBUG_VARIABLE) == "1":
        _write(sys.stderr, "".join(traceback.format_exception(error)))
    _write(sys.stderr, f"error: {failure.message}\n")


def _ended_by(error: BaseException, as_json: bool) -> int:
    failure = failure_of(error)
    complain(failure, error)
    if as_json:
        with suppress(OSError):
            _write_json(failure.document())
    return failure.exit_code


def _ends(text: str) -> str:
    """Keep the first and the last line of a text: of a traceback, what failed and how."""
    lines = text.replace("Traceback (most recent call last):", "").splitlines()
    told = [line.strip().rstrip(":") for line in lines if line.strip()] or [""]
    return told[0] if len(told) == 1 else f"{told[0]}: {told[-1]}"


def _sentence(text: str) -> str:
    return one_line(" ".join(text.split())).removesuffix(".")


def _print(outcome: Outcome, as_json: bool) -> None:
    try:
        if as_json:
            _write_json(outcome.document)
        elif sys.stdout is not None:
            from drivegate.output.console import console_for

            outcome.show(console_for(sys.stdout))
            sys.stdout.flush()
    except BrokenPipeError:
        # The reader has seen enough; what the command came to stands.
        _leave_unread(sys.stdout)


def _write_json(document: Mapping[str, Any]) -> None:
    from drivegate.results.result import finite

    _write(sys.stdout, json.dumps(finite(document), indent=2, allow_nan=False) + "\n")


def _write(stream: TextIO | None, text: str) -> None:
    if stream is None:
        return
    try:
        stream.write(text)
        stream.flush()
    except BrokenPipeError:
        _leave_unread(stream)


def _leave_unread(stream: TextIO) -> None:
    """Let what is still buffered go nowhere, so that the interpreter ends in peace."""
    with suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
