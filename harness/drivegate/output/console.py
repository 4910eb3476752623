"""The console for people, on which nothing that a candidate or a file says can act."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Final, TextIO, cast

from rich.box import SIMPLE
from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.table import Table
from rich.text import Text

from drivegate.output.streams import StyledStream, leave_unread, printable
from drivegate_cases.documents.wording import one_line

WIDTH_OF_A_FILE: Final = 160
"""Columns where the output is no terminal and none are given."""

ADVISED: Final = "advisory fail"
"""Name of the style of a failed check that only advises."""
STYLES: Final = {
    "pass": "green",
    "fail": "bold red",
    ADVISED: "yellow",
    "contested": "yellow",
    "not yet witnessed": "yellow",
    "waived": "yellow",
    "unexpectedly passes": "bold yellow",
    "no difference": "dim",
    "too few pairs": "dim",
    "not applicable": "dim",
    "inconclusive": "yellow",
    "never judged": "yellow",
}
"""Style of a verdict; whatever is not in it is a fault."""


class _GuardedConsole(Console):
    """A console on which no text acts, and which prints nothing more once its reader has gone.

    The command and its exit code do not change then.
    """

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        for segment in super().render(renderable, options):
            # Only movements of the cursor that are the console's own may have control characters.
            yield segment if segment.control else segment._replace(text=printable(segment.text))

    def on_broken_pipe(self) -> None:
        self.quiet = True
        leave_unread(self.file)


def console_for(stream: TextIO) -> Console:
    """Make a console that takes text as it is: no markup, no emoji, no highlighting."""
    has_width = stream.isatty() or "COLUMNS" in os.environ
    # Only tables are wrapped: a path or a command on more than one line could not be copied.
    return _GuardedConsole(
        file=cast(TextIO, StyledStream(stream)),
        markup=False,
        emoji=False,
        highlight=False,
        soft_wrap=True,
        width=None if has_width else WIDTH_OF_A_FILE,
    )


def plain(text: object, style: str = "") -> Text:
    """Make any text harmless and keep it on one line."""
    return Text(one_line(str(text)), style=style)


def print_line(console: Console, text: object, style: str = "") -> None:
    """Print any text, made harmless, on one line."""
    console.print(plain(text, style))


def print_ending(console: Console, files: Iterable[object], hint: str = "") -> None:
    """Print the files that were written and the next step, if there are any."""
    for path in files:
        print_line(console, f"written: {path}")
    if hint:
        print_line(console, f"next: {hint}", "dim")


def verdict_text(verdict: str, *, counts: bool = True) -> Text:
    """Write a verdict in its style; a failure that does not count is one that advises."""
    return plain(verdict, STYLES.get(verdict if counts or verdict != "fail" else ADVISED, "bold red"))


def table(*columns: str, right: tuple[str, ...] = (), title: str | None = None) -> Table:
    """Make an empty table in the style of all of them."""
    made = Table(
        box=SIMPLE, title=None if title is None else plain(title), title_justify="left", pad_edge=False
    )
    for column in columns:
        made.add_column(plain(column), justify="right" if column in right else "left", overflow="fold")
    return made


def number(value: float | None, digits: int = 3) -> str:
    """Write a number for a table; what rounds to zero has no sign."""
    return "–" if value is None or value != value else f"{value:z.{digits}f}"
