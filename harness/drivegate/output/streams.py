"""Standard streams whose reader may go away at any time."""

from __future__ import annotations

import os
from contextlib import suppress
from typing import IO, TextIO


def write_to(stream: TextIO | None, text: str) -> None:
    """Write all of a text, unless nobody reads it any more."""
    if stream is None:
        return
    try:
        stream.write(text)
        stream.flush()
    except BrokenPipeError:
        leave_unread(stream)


def leave_unread(stream: IO[str]) -> None:
    """Let what is still buffered go nowhere, so that the interpreter ends in peace."""
    with suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
