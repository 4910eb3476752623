"""``drivegate verify``: whether a kept result is unchanged, and who signed it."""

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
@click.option(
    "--key",
    type=click.Path(path_type=Path),
    metavar="PUBLIC",
    help="Public key that the result must be signed by: a PEM file, or a .pub file of ssh-keygen.",
)
@json_option
def command(file: Path, key: Path | None) -> Outcome:
    """Check that the result in FILE, a result.json, is unchanged and that its signature is valid, and show whose it is.

    The exit code is 0 when all of that holds, whatever the result's verdict, and 1 when the result was altered, its
    signature is invalid, or it is not signed by the key PUBLIC.
    """
    from drivegate.studies.verify import verification

    document = verification(file, key)
    return Outcome(document, lambda console: _show(console, document), document["exit_code"])


def _show(console: Console, document: dict[str, Any]) -> None:
    from drivegate.output.console import plain, verdict_text

    if document["unchanged"]:
        heading = plain(f"{document['candidate']}: ")
        heading.append_text(verdict_text(document["verdict"]))
        console.print(heading)
    style = "green" if document["outcome"] == "valid" else "bold red" if document["exit_code"] else "yellow"
    line = plain(document["outcome"], style)
    line.append(f": {document['message']}")
    console.print(line)
