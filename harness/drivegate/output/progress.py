"""Progress of any command on standard error: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final, TextIO

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from drivegate.output.console import console_for, plain
from drivegate.output.streams import write_to
from drivegate_cases.documents.wording import one_line

SECONDS_BETWEEN_LINES: Final = 30.0
"""Least time between two lines of a phase where the output is no terminal (s)."""
SHARE_BETWEEN_LINES: Final = 0.1
"""Least share of the work between these two lines."""


class Display:
    """Progress that nobody sees; one that is seen takes the same calls."""

    def __init__(self) -> None:
        self._title = ""
        self._began = time.monotonic()

    def begin(self, title: str, total: int | None = None, words: str = "starting") -> None:
        """Begin a piece of work of so many parts, None where they are not counted."""
        self._title = one_line(title)
        self._began = time.monotonic()
        self._begin_bar(total, words)

    def headline(self, words: str) -> None:
        """Print, on a line of its own that stays, what the work is."""

    def phase(self, words: str, done: int = 0, total: int | None = None) -> None:
        """Enter a phase of the work, or report how many of its parts are done."""
        self._move_bar(words, done, total)
        self._print(words if total is None else f"{words}: {done} of {total}", done, total, always=done == 0)

    def advance(
        self, done: int, total: int, words: str = "", *, unit: str = "", always: bool = False
    ) -> None:
        """Report how many parts are done; `always` on a line of its own, else on one only now and then."""
        counted = f"{done} of {total} {unit}".rstrip()
        self._move_bar(words, done, total)
        self._print(f"{counted}, {words}" if words else counted, done, total, always=always)

    def time_left(self, done: int, total: int) -> str:
        """State how long the rest takes at the rate so far; nothing before there is one."""
        if not 0 < done < total:
            return ""
        return f"{duration_in_words((time.monotonic() - self._began) * (total - done) / done)} left"

    def announce(self, words: str) -> None:
        """Print at once, on a line of its own that stays."""

    def _begin_bar(self, total: int | None, words: str) -> None:
        """Show a new bar."""

    def _move_bar(self, words: str, done: int, total: int | None) -> None:
        """Show the bar as it is now; it pulses where parts are not counted."""

    def _print(self, words: str, done: int, total: int | None, *, always: bool) -> None:
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
        yield _Lines(stream)


class _Bar(Display):
    def __init__(self, bars: Progress) -> None:
        super().__init__()
        self._bars = bars

    def _begin_bar(self, total: int | None, words: str) -> None:
        for shown in self._bars.task_ids:
            self._bars.remove_task(shown)
        self._task = self._bars.add_task(self._title, total=total, words=one_line(words))

    def _move_bar(self, words: str, done: int, total: int | None) -> None:
        self._bars.update(self._task, completed=done, words=one_line(words))
        # An update with no total would leave the last one.
        self._bars.tasks[0].total = total

    def headline(self, words: str) -> None:
        self._bars.console.print(plain(words))

    def announce(self, words: str) -> None:
        self._bars.console.print(plain(f"{self._title}: {words}"))


class _Lines(Display):
    """Few lines, for the log of a machine: phases, then a part of the work that took a while; none twice."""

    def __init__(self, stream: TextIO) -> None:
        super().__init__()
        self._stream: TextIO | None = stream
        self._next = (0.0, 0.0)
        self._printed: set[str] = set()

    def _begin_bar(self, total: int | None, words: str) -> None:  # noqa: ARG002  (what a bar needs)
        self._print_next_after(0.0)

    def headline(self, words: str) -> None:
        self._put(one_line(words))

    def announce(self, words: str) -> None:
        self._put(f"{self._title}: {one_line(words)}")

    def _print(self, words: str, done: int, total: int | None, *, always: bool) -> None:
        share = done / total if total else 0.0
        now, next_share = time.monotonic(), self._next[1]
        # The shares of parts add up to a tenth only almost.
        due = share > next_share - 1e-9 and now >= self._next[0]
        if (always or due) and self._put(f"{self._title}: {one_line(words)}"):
            self._print_next_after(share)

    def _print_next_after(self, share: float) -> None:
        self._next = (time.monotonic() + SECONDS_BETWEEN_LINES, share + SHARE_BETWEEN_LINES)

    def _put(self, line: str) -> bool:
        """Print a line unless it has been printed before."""
        if self._stream is None or line in self._printed:
            return False
        self._printed.add(line)
        try:
            write_to(self._stream, f"{line}\n")
        except (OSError, ValueError):
            # Progress that nobody reads is no reason to end what it is about.
            self._stream = None
        return True


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
        display.advance(done, total, words, unit=unit, always=done == before or done >= total)

    return report


def duration_in_words(seconds: float) -> str:
    """Write a time as people say it."""
    whole = round(seconds)
    if whole < 100:
        return f"{whole} s"
    hours, minutes = divmod(round(seconds / 60.0), 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min"
