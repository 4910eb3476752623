"""Progress of any command on standard error: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final, TextIO

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from drivegate.output.console import console_for, plain
from drivegate_cases.documents.wording import one_line

SECONDS_BETWEEN_LINES: Final = 2.0
"""Least time between two lines where the output is no terminal (s)."""


class Display:
    """Progress that nobody sees; one that is seen takes the same calls."""

    def __init__(self) -> None:
        self._title = ""
        self._began = time.monotonic()

    def begin(self, title: str, total: int, words: str = "compiling and starting") -> None:
        """Begin a piece of work of so many parts; a line has nothing to report of it yet."""
        self._title = one_line(title)
        self._began = time.monotonic()
        self._begin_bar(total, words)

    def advance(
        self, done: int, total: int, words: str = "", *, unit: str = "", always: bool = False
    ) -> None:
        """Tell how many parts are done, on a line of its own `always` or when the last one was long enough ago."""
        counted = f"{done} of {total} {unit}".rstrip()
        self._move_bar(words, done, total)
        self._print(f"{counted}, {words}" if words else counted, always)

    def time_left(self, done: int, total: int) -> str:
        """Tell how long the rest takes at the rate so far; nothing before there is one."""
        if not 0 < done < total:
            return ""
        return f"{duration_in_words((time.monotonic() - self._began) * (total - done) / done)} left"

    def remark(self, words: str, *, always: bool = False) -> None:
        """Tell what is no part done."""
        self._move_bar(words)
        self._print(words, always)

    def announce(self, words: str) -> None:
        """Tell at once, on a line of its own that stays, what is told but once."""

    def _begin_bar(self, total: int, words: str) -> None:
        """Show a new bar."""

    def _move_bar(self, words: str, done: int | None = None, total: int | None = None) -> None:
        """Show the bar as it is now."""

    def _print(self, words: str, always: bool) -> None:
        """Print a line."""


@contextmanager
def progress_on(stream: TextIO | None) -> Iterator[Display]:
    """Show progress as long as the context lasts."""
    if stream is None:
        yield Display()
    elif stream.isatty():
        with Progress(
            TextColumn("{task.description}", markup=False),
            BarColumn(bar_width=30),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TextColumn("{task.fields[words]}", markup=False),
            console=console_for(stream),
            transient=True,
        ) as bars:
            yield _Bar(bars)
    else:
        lines = _Lines(stream)
        with lines.beating():
            yield lines


class _Bar(Display):
    def __init__(self, bars: Progress) -> None:
        super().__init__()
        self._bars = bars

    def _begin_bar(self, total: int, words: str) -> None:
        self._task = self._bars.add_task(self._title, total=total, words=words)

    def _move_bar(self, words: str, done: int | None = None, total: int | None = None) -> None:
        self._bars.update(self._task, completed=done, total=total, words=one_line(words))

    def announce(self, words: str) -> None:
        self._bars.console.print(plain(f"{self._title}: {words}"))


class _Lines(Display):
    def __init__(self, stream: TextIO) -> None:
        super().__init__()
        self._stream: TextIO | None = stream
        self._next = 0.0
        self._last = ""
        self._turn = threading.Lock()

    @contextmanager
    def beating(self) -> Iterator[None]:
        """Tell that work goes on, as long as the context lasts, where nothing else has been told for a while."""
        ended = threading.Event()
        beat = threading.Thread(target=self._beat, args=(ended,), daemon=True)
        beat.start()
        try:
            yield
        finally:
            ended.set()
            beat.join()

    def _beat(self, ended: threading.Event) -> None:
        while not ended.wait(SECONDS_BETWEEN_LINES / 4.0):
            due = max(self._next, self._began + SECONDS_BETWEEN_LINES)
            if self._title and time.monotonic() >= due - SECONDS_BETWEEN_LINES / 4.0:
                told = f"{self._last}, " if self._last else ""
                self._write(f"{told}{duration_in_words(time.monotonic() - self._began)} so far")

    def _begin_bar(self, total: int, words: str) -> None:  # noqa: ARG002  (what a bar needs)
        self._last = words

    def announce(self, words: str) -> None:
        self._write(words)

    def _print(self, words: str, always: bool) -> None:
        self._last = words
        if always or time.monotonic() >= self._next:
            self._write(words)

    def _write(self, words: str) -> None:
        with self._turn:
            self._next = time.monotonic() + SECONDS_BETWEEN_LINES
            self._put(words)

    def _put(self, words: str) -> None:
        if self._stream is None:
            return
        try:
            print(f"{self._title}: {one_line(words)}", file=self._stream, flush=True)
        except (OSError, ValueError):
            # Progress that nobody reads is no reason to end what it is about.
            self._stream = None


def with_rate(
    display: Display,
    title: str,
    total: int,
    unit: str = "runs",
    *,
    clock: Callable[[], float] = time.monotonic,
) -> Callable[[int, int], None]:
    """Make what takes the number of parts done, and of those done before, and reports rate and time left."""
    began = clock()
    display.begin(title, total, "starting")

    def report(done: int, before: int) -> None:
        nonlocal began
        if done == before:
            # Compiling and starting say nothing about how fast parts are done.
            began = clock()
        made, seconds = done - before, clock() - began
        if made <= 0 or seconds <= 0.0:
            words = "starting" if done < total else "complete"
        else:
            words = (
                f"{made / seconds:.3g} {unit}/s, {duration_in_words((total - done) * seconds / made)} left"
            )
        display.advance(done, total, words, unit=unit, always=done >= total)

    return report


def duration_in_words(seconds: float) -> str:
    """Write a time as people tell it."""
    whole = round(seconds)
    if whole < 100:
        return f"{whole} s"
    hours, minutes = divmod(round(seconds / 60.0), 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min"
