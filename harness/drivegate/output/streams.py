"""Standard streams whose reader may go away at any time, or take what it reads for a command.

CI servers obey lines of a job's log: GitHub Actions those that begin with ``::`` or have ``##[`` in them, Azure
Pipelines those with ``##vso[``. What a candidate calls itself, or raises, must not become one.
"""

from __future__ import annotations

import os
import re
from contextlib import suppress
from typing import IO, Any, Final, TextIO

_COMMAND: Final = re.compile(r"^(\s*):(?=:)|#(?=#(?:vso)?\[)", re.MULTILINE | re.IGNORECASE)


def without_commands(text: str) -> str:
    """Break up with a space what a CI server would obey."""
    return _COMMAND.sub(lambda found: f"{found[1]}: " if found[0].endswith(":") else "# ", text)


class LogStream:
    """A stream for text in which nothing is a command; otherwise the one that it writes to."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        return self._stream.write(without_commands(text))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


def write_to(stream: TextIO | None, text: str) -> None:
    """Write all of a text, unless nobody reads it any more."""
    if stream is None:
        return
    try:
        stream.write(without_commands(text))
        stream.flush()
    except BrokenPipeError:
        leave_unread(stream)


def leave_unread(stream: IO[str]) -> None:
    """Let what is still buffered go nowhere, so that the interpreter ends in peace."""
    with suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
