"""Progress of a bench on standard error: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Final, TextIO

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from drivegate.output.console import console_for

SECONDS_BETWEEN_LINES: Final = 5.0
"""Least time between two lines where the output is no terminal (s)."""

Tell = Callable[[int, str], None]
"""Takes the number of measurements that are done, and the name of the one that begins."""


@contextmanager
def bench_progress_on(stream: TextIO | None, total: int) -> Iterator[Tell]:
    """Show progress as long as the context lasts."""
    if stream is None:
        yield lambda _done, _name: None
    elif stream.isatty():
        with Progress(
            TextColumn("{task.description}", markup=False),
            BarColumn(bar_width=30),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            console=console_for(stream),
            transient=True,
        ) as bars:
            task = bars.add_task("", total=total)
            yield lambda done, name: bars.update(task, completed=done, description=name)
    else:
        yield _Lines(stream, total)


class _Lines:
    def __init__(self, stream: TextIO, total: int) -> None:
        self._stream, self._total, self._told = stream, total, -float("inf")

    def __call__(self, done: int, name: str) -> None:
        now = time.monotonic()
        if now - self._told < SECONDS_BETWEEN_LINES and done < self._total:
            return
        self._told = now
        # Progress that nobody reads is no reason to end a bench.
        with suppress(OSError):
            print(f"bench: {done} of {self._total}, {name}", file=self._stream, flush=True)
