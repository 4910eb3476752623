"""``drivegate verify``: whether a kept result is unchanged."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import json_option

if TYPE_CHECKING:
    from rich.console import Console


@click.command("verify")
@click.argument("file", type=click.Path(path_type=Path), metavar="FILE")
@json_option
def command(file: Path) -> Outcome:
    """Check that the result in FILE, a result.json, is unchanged since its content hash was computed.

    The exit code is 0 when it is, whatever the result's verdict, and 1 when it was altered. The hash shows accidental
    changes; to show who vouches for a result, sign its file, for instance with ssh-keygen -Y sign.
    """
    from drivegate.studies.verify import verification

    document = verification(file)
    return Outcome(document, lambda console: _show(console, document), document["exit_code"])


def _show(console: Console, document: dict[str, Any]) -> None:
    from drivegate.output.console import plain, verdict_text

    if document["unchanged"]:
        heading = plain(f"{document['candidate']}: ")
        heading.append_text(verdict_text(document["verdict"]))
        console.print(heading)
    line = plain(document["outcome"], "green" if document["unchanged"] else "bold red")
    line.append(f": {document['message']}")
    console.print(line)
