"""``drivegate include-dir``: where the header of the candidate contract is."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import json_option

if TYPE_CHECKING:
    from rich.console import Console

SCHEMA = 1


@click.command("include-dir")
@json_option
def command() -> Outcome:
    """Print the folder of the headers, as in: cc -shared -fPIC -I"$(drivegate include-dir)" mine.c -o mine.so."""
    from drivegate.candidates.contract import HEADERS
    from drivegate.candidates.native.compiler import include_folder

    folder = include_folder()
    document = {
        "schema": SCHEMA,
        "kind": "include-dir",
        "folder": str(folder),
        "header": str(folder / HEADERS["current"]),
        "headers": [str(folder / header) for header in HEADERS.values()],
    }

    def show(console: Console) -> None:
        # As it is, however long: a script reads it.
        console.file.write(f"{folder}\n")

    return Outcome(document, show)
