"""``drivegate man``: the help of every command as pages for man."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import json_option

SCHEMA = 1


@click.command("man")
@click.argument("folder", type=click.Path(file_okay=False, path_type=Path), metavar="FOLDER")
@json_option
def command(folder: Path) -> Outcome:
    """Write a manual page for each command into FOLDER.

    After 'drivegate man ~/.local/share/man/man1', 'man drivegate-check' shows the help of drivegate check. Pages that
    an earlier drivegate wrote there are replaced.
    """
    from drivegate.commands.command_line import command_line
    from drivegate.output.manual_page import manual_pages
    from drivegate_cases.documents.atomic_write import write_atomically
    from drivegate_cases.documents.wording import shown_path
    from drivegate_models.errors import InputError

    pages = manual_pages(command_line)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"the folder {shown_path(folder)} cannot be made: {error.strerror}; name another one"
        ) from error
    for name, text in pages.items():
        write_atomically(folder / name, text)
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "kind": "man",
        "folder": str(folder),
        "files": list(pages),
    }
    return Outcome(
        document, lambda console: console.file.write(f"{len(pages)} pages written into {folder}\n")
    )
