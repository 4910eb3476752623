"""Progress of a campaign on standard error: a bar with rate and time left on a terminal, plain lines elsewhere."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Final, TextIO

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

from drivegate.output.console import console_for
from drivegate.studies.campaign.engine import Tell
from drivegate_cases.documents.wording import one_line

SECONDS_BETWEEN_LINES: Final = 2.0


@contextmanager
def campaign_progress_on(
    stream: TextIO | None,
    name: str,
    runs: int,
    *,
    unit: str = "runs",
    clock: Callable[[], float] = time.monotonic,
) -> Iterator[Tell]:
    """Show progress as long as the context lasts."""
    rate = _Rate(runs, unit, clock)
    if stream is None:
        yield _nowhere
    elif stream.isatty():
        with Progress(
            TextColumn("{task.description}", markup=False),
            BarColumn(bar_width=30),
            MofNCompleteColumn(),
            TextColumn("{task.fields[rate]}", markup=False),
            console=console_for(stream),
            transient=True,
        ) as bars:
            task = bars.add_task(one_line(name), total=runs, rate="starting")
            yield lambda kept, before: bars.update(task, completed=kept, rate=rate.in_words(kept, before))
    else:
        yield _Lines(stream, one_line(name), runs, rate, clock)


def _nowhere(_kept: int, _before: int) -> None:
    return


class _Rate:
    """How fast runs are made, those that were there before left out."""

    def __init__(self, runs: int, unit: str, clock: Callable[[], float]) -> None:
        self._runs = runs
        self.unit = unit
        self._clock = clock
        self._began = clock()

    def in_words(self, kept: int, before: int) -> str:
        """Tell rate and time left."""
        if kept == before:
            # Compiling and starting say nothing about how fast runs are.
            self._began = self._clock()
        made, seconds = kept - before, self._clock() - self._began
        if made <= 0 or seconds <= 0.0:
            return "starting" if kept < self._runs else "complete"
        left = (self._runs - kept) * seconds / made
        return f"{made / seconds:.3g} {self.unit}/s, {_duration(left)} left"


class _Lines:
    def __init__(self, stream: TextIO, name: str, runs: int, rate: _Rate, clock: Callable[[], float]) -> None:
        self._stream, self._name, self._runs, self._rate, self._clock = stream, name, runs, rate, clock
        self._told = -float("inf")

    def __call__(self, kept: int, before: int) -> None:
        now = self._clock()
        if now - self._told < SECONDS_BETWEEN_LINES and kept < self._runs:
            return
        self._told = now
        # Progress that nobody reads is no reason to end a campaign.
        with suppress(OSError):
            words = self._rate.in_words(kept, before)
            print(
                f"{self._name}: {kept} of {self._runs} {self._rate.unit}, {words}",
                file=self._stream,
                flush=True,
            )


def _duration(seconds: float) -> str:
    whole = round(seconds)
    if whole < 100:
        return f"{whole} s"
    hours, minutes = divmod(round(seconds / 60.0), 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min"
