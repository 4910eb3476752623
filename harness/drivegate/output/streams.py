"""Standard streams whose reader may go away at any time, or take what it reads for a command.

CI servers obey lines of a job's log: GitHub Actions those that begin with ``::`` or have ``##[`` in them, Azure
Pipelines those with ``##vso[``, TeamCity those with ``##teamcity[``. Terminals obey control characters. What a
candidate or a file is called, or what a compiler or an exception says, must not become any of these.

All text of a command leaves through `guard_output`: what drivegate prints, what it logs, warnings of Python and
tracebacks of what nobody caught.
"""

from __future__ import annotations

import logging
import os
import re
import sys
from contextlib import suppress
from typing import IO, Any, Final, TextIO

from drivegate_cases.documents.wording import one_line

_BLANK: Final = r"(?:\s|\x1b\[[0-9;]*m)*"
_AT_START: Final = re.compile(rf"{_BLANK}:(?=:)")
_BRACKET: Final = re.compile(r"##[A-Za-z]*(?=\[)")
_UNDECIDED_START: Final = re.compile(rf"{_BLANK}(:?)")
_UNDECIDED_END: Final = re.compile(r"##?[A-Za-z]{0,99}$")


def without_commands(text: str) -> str:
    """Break up with a space what a CI server would obey."""
    if "::" not in text and "##" not in text:
        return text
    return "".join(map(_line_without_commands, text.splitlines(keepends=True)))


def _line_without_commands(line: str) -> str:
    start = _AT_START.match(line)
    if start is not None:
        line = f"{start[0]} {line[start.end() :]}"
    return _BRACKET.sub(r"\g<0> ", line)


def printable(text: str) -> str:
    """Write what a terminal would obey as escape sequences in ASCII; lines and tabs stay."""
    if text.replace("\n", "").isprintable():
        return text
    return "\n".join("\t".join(map(one_line, line.split("\t"))) for line in text.split("\n"))


def harmless(text: str) -> str:
    """Write text of any origin so that neither a terminal nor a CI server obeys any of it."""
    return without_commands(printable(text))


class LogStream:
    """A stream for text in which nothing is a command; otherwise the one that it writes to.

    It has no ``buffer``, past which text would get out unseen.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._undecided = ""

    def write(self, text: str | bytes) -> int:
        # click writes bytes to a stream without a buffer.
        self.write_styled(
            printable(text if isinstance(text, str) else text.decode(errors="backslashreplace"))
        )
        return len(text)

    def write_styled(self, text: str) -> int:
        """Write text with colours and movements of the cursor that are drivegate's own."""
        # A command may come in pieces: what this line ends in so far decides, and is written already.
        line = self._undecided + text
        self._stream.write(without_commands(line)[len(self._undecided) :])
        self._undecided = _undecided(line)
        return len(text)

    def writelines(self, lines: list[str]) -> None:
        self.write("".join(lines))

    def __getattr__(self, name: str) -> Any:
        if name == "buffer":
            raise AttributeError(name)
        return getattr(self._stream, name)


def _undecided(text: str) -> str:
    """Return the end of a text that could become a command with what follows it."""
    line = f"{text}x".splitlines()[-1][:-1]
    start = _UNDECIDED_START.fullmatch(line)
    if start is not None:
        return start[1]
    end = _UNDECIDED_END.search(line)
    # Any letter in front shows that the line has begun.
    return f"x{end[0]}" if end else "x"


class StyledStream:
    """A `LogStream` for a console that has made its texts printable."""

    def __init__(self, stream: TextIO) -> None:
        self._log = log_stream(stream)
        self.write = self._log.write_styled

    def __getattr__(self, name: str) -> Any:
        return getattr(self._log, name)


def log_stream(stream: TextIO | LogStream) -> LogStream:
    return stream if isinstance(stream, LogStream) else LogStream(stream)


class _LogFilter(logging.Filter):
    """Makes the texts of records harmless, whichever handler writes them."""

    def filter(self, record: logging.LogRecord) -> bool:
        record.msg, record.args = harmless(record.getMessage()), ()
        return True


_LOG_FILTER: Final = _LogFilter()


def guard_log() -> None:
    """Make harmless what drivegate logs."""
    logging.getLogger("drivegate").addFilter(_LOG_FILTER)


def guard_output() -> None:
    """Make harmless whatever this process writes on its standard streams from now on."""
    guard_log()
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is not None:
            # A console that cannot show a character is no reason to fail.
            if hasattr(stream, "reconfigure"):
                stream.reconfigure(errors="backslashreplace")
            setattr(sys, name, log_stream(stream))


def write_to(stream: TextIO | None, text: str) -> None:
    """Write all of a text, unless nobody reads it any more."""
    if stream is None:
        return
    try:
        log_stream(stream).write(text)
        stream.flush()
    except BrokenPipeError:
        leave_unread(stream)


def leave_unread(stream: IO[str]) -> None:
    """Let what is still buffered go nowhere, so that the interpreter ends in peace."""
    with suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
