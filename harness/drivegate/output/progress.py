"""Progress of a check on standard error: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from drivegate.gate.events import CheckFinished, CheckStarted, Event, RunDone, Shrinking
from drivegate.output.console import console_for
from drivegate.output.subscription import Handler
from drivegate_cases.documents.wording import one_line

SECONDS_BETWEEN_LINES = 2.0


@contextmanager
def progress_on(stream: TextIO | None) -> Iterator[Handler]:
    """Show progress as long as the context lasts."""
    if stream is None:
        yield lambda _: None
    elif stream.isatty():
        with Progress(
            TextColumn("{task.description}", markup=False),
            BarColumn(bar_width=30),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TextColumn("{task.fields[worst]}", markup=False),
            console=console_for(stream),
            transient=True,
        ) as bars:
            yield _Bar(bars)
    else:
        yield _Lines(stream)


class _Bar:
    def __init__(self, bars: Progress) -> None:
        self._bars = bars

    def __call__(self, event: Event) -> None:
        if isinstance(event, CheckStarted):
            self._task = self._bars.add_task(
                one_line(event.candidate_name), total=event.planned_runs, worst="compiling and starting"
            )
        elif isinstance(event, RunDone):
            self._bars.update(
                self._task, completed=event.done, total=event.planned, worst=one_line(_worst(event))
            )
        elif isinstance(event, Shrinking):
            self._bars.update(self._task, worst=_simplified(event))


class _Lines:
    def __init__(self, stream: TextIO) -> None:
        self._stream: TextIO | None = stream
        self._next = 0.0
        self._name = ""

    def __call__(self, event: Event) -> None:
        now = time.monotonic()
        if isinstance(event, CheckStarted):
            # Nothing is told yet: a candidate that is refused is told of in one sentence.
            self._name = one_line(event.candidate_name)
        elif isinstance(event, RunDone):
            if now >= self._next:
                self._next = now + SECONDS_BETWEEN_LINES
                self._tell(one_line(f"{event.done} of {event.planned} runs, {_worst(event)}".rstrip(", ")))
        elif isinstance(event, Shrinking):
            if now >= self._next:
                self._next = now + SECONDS_BETWEEN_LINES
                self._tell(_simplified(event))
        elif isinstance(event, CheckFinished):
            self._tell(f"{event.result.runs} runs made, {event.result.verdict}")

    def _tell(self, text: str) -> None:
        if self._stream is None:
            return
        try:
            print(f"{self._name}: {text}", file=self._stream, flush=True)
        except OSError:
            # Progress that nobody reads is no reason to end a check.
            self._stream = None


def _worst(event: RunDone) -> str:
    return f"least margin so far {event.worst}" if event.worst else ""


def _simplified(event: Shrinking) -> str:
    return f"{event.done} of {event.planned} counterexamples made simpler"
