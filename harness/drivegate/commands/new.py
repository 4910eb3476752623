"""``drivegate new``: a small candidate that works, as a place to start from."""

from __future__ import annotations

from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import drive_option, json_option, named_drive

if TYPE_CHECKING:
    from rich.console import Console

SCHEMA = 1
DRIVE = "drive"
"""The one kind that is no candidate."""
CHOICES = ("python", "numba", "c", "rust", "cortex-m", "exec", "python-duty", "embedded-coder", DRIVE)


@click.command("new")
@click.argument("kind", type=click.Choice(CHOICES))
@click.argument("name")
@click.option(
    "--output",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Folder to make; by default NAME. Nothing is ever overwritten.",
)
@drive_option
@json_option
def command(kind: str, name: str, output: Path | None, drive: str | None) -> Outcome:
    """Write a small controller called NAME into a new folder, with manifest, test, waivers and a workflow for CI.

    The kind drive is no controller: NAME is then a new file such as my-drive.toml, with a comment for each key, and has
    the values of the paper's drive, or of that of --drive, to be replaced by one's own; what follows from them is left
    out.

    The kinds python, numba, c, rust, cortex-m (the image for a microcontroller, emulated) and exec have the same
    algorithm: a speed regulator, and a line of angles. It meets the contract and most checks; what it fails is waived
    for 90 days and is the exercise. python-duty and embedded-coder (C as generated from Simulink) answer with duty
    ratios, by field-oriented control. With --drive its manifest names that drive, whose file is copied into the folder.
    """
    if kind == DRIVE:
        return _new_drive(Path(name), output, drive)

    from drivegate.results.waivers import present_day
    from drivegate.studies.new import KINDS, write_candidate

    folder = Path(name) if output is None else output
    named_drive(drive)
    written = write_candidate(kind, name, folder, present_day(), drive)
    build = KINDS[kind].build
    check = "drivegate check candidate.toml --waivers waivers.toml"
    steps = [f"cd {quote(str(folder))}", *([build] if build else []), check]
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "kind": "new",
        "candidate": {"name": name, "kind": kind},
        "folder": str(folder),
        "files": [str(file) for file in written],
        "next": steps,
    }
    return Outcome(document, lambda console: _show(console, document))


def _new_drive(file: Path, output: Path | None, start: str | None) -> Outcome:
    if output is not None:
        raise click.UsageError("--output goes with a candidate only; NAME is the file of a drive")

    from drivegate.drives.kinds import drive_for
    from drivegate.studies.new import write_drive

    written = write_drive(file, drive_for(None, named_drive(start)))
    look = f"drivegate drive {quote(str(file))}"
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "kind": "new",
        "drive": written.identity(),
        "folder": str(file.parent),
        "files": [file.name],
        "next": [f"put your values into {file}", look],
    }
    return Outcome(document, lambda console: _show(console, document))


def _show(console: Console, document: dict[str, Any]) -> None:
    from drivegate.output.console import plain

    console.print(plain(f"written into {document['folder']}:"))
    for file in document["files"]:
        console.print(plain(f"  {file}"))
    joint = ", then " if "drive" in document else " && "
    console.print(plain(f"next: {joint.join(document['next'])}", "dim"))
