"""``drivegate reproduce``: every published figure and number beside ours."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import folder_option, json_option

if TYPE_CHECKING:
    from rich.console import Console

DEFAULT_OUTPUT = "drivegate-reproduction"

_COLUMNS = ("published", "ours", "residual", "tolerance", "verdict")


@click.command("reproduce")
@folder_option(DEFAULT_OUTPUT, "Folder of the page, the figures and the numbers.")
@json_option
def command(output: Path) -> Outcome:
    """Compute every figure and number of the paper that physics can give, and compare it with what is published.

    The exit code is 0 when all were computed, whether or not they agree.
    """
    from drivegate.output.report_folder import ReportFolder
    from drivegate_lab.paper.report import reproduce

    with ReportFolder(output) as folder:
        document = reproduce(folder.staging)
        folder.commit()
    return Outcome(document, lambda console: _show(console, document, output))


def _show(console: Console, document: dict[str, Any], output: Path) -> None:
    from drivegate.output.console import plain, table

    listed = table("fact", "quantity", *_COLUMNS)
    for row in document["numbers"]:
        listed.add_row(*(plain(row[key]) for key in ("fact", "quantity", *_COLUMNS)))
    console.print(listed)
    counts = ", ".join(f"{count} {verdict}" for verdict, count in document["verdicts"].items())
    console.print(plain(f"{document['paper']}: {counts}"))
    console.print(plain(f"page: {output / document['page']}"))
    console.print(plain("next: open the page; its findings explain what is not reproduced", "dim"))
