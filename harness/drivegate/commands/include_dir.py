"""``drivegate include-dir``: where the header of the candidate contract is."""

from __future__ import annotations

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import json_option

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

    # Written past the console, which would fold a long path: a script reads it.
    return Outcome(document, lambda console: console.file.write(f"{folder}\n"))
