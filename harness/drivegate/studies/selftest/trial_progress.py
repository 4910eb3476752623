"""Progress of the faulty controllers on standard error: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TextIO, TypeAlias

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from drivegate.output.console import console_for
from drivegate.studies.selftest.matrix import FaultRow

TITLE = "faulty controllers"

Tell: TypeAlias = Callable[[FaultRow], None]
"""Takes what has become of each faulty controller."""


@contextmanager
def trial_progress_on(stream: TextIO | None, planned: int) -> Iterator[Tell]:
    """Show progress as long as the context lasts."""
    if stream is None:
        yield lambda _: None
    elif stream.isatty():
        with Progress(
            TextColumn("{task.description}", markup=False),
            BarColumn(bar_width=30),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TextColumn("{task.fields[last]}", markup=False),
            console=console_for(stream),
            transient=True,
        ) as bars:
            task = bars.add_task(TITLE, total=planned, last="compiling and starting")
            yield lambda row: bars.update(task, advance=1, last=in_short(row))
    else:
        yield _Lines(stream, planned)


class _Lines:
    def __init__(self, stream: TextIO, planned: int) -> None:
        self._stream = stream
        self._planned = planned
        self._done = 0

    def __call__(self, row: FaultRow) -> None:
        self._done += 1
        # Progress that nobody reads is no reason to end a self-test.
        with suppress(OSError):
            line = f"{TITLE}: {self._done} of {self._planned}, {in_short(row)}"
            print(line, file=self._stream, flush=True)


def in_short(row: FaultRow) -> str:
    """Tell in a few words what has become of a faulty controller."""
    slowest = row.slowest
    if slowest is None:
        return f"{row.name}: missed by {row.check} in {row.runs} runs"
    return f"{row.name}: caught by {row.check} in run {slowest.runs}"
