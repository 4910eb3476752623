"""``drivegate checks``: what is required of a candidate, why, and what exercises it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import drive_option, json_option

if TYPE_CHECKING:
    from rich.console import Console

SCHEMA = 1

_COLUMNS = ("id", "level", "subject", "source", "requirement", "limit")


@click.command("checks")
@drive_option
@json_option
def command(drive: str | None) -> Outcome:
    """List the checks with their requirements, sources and limits, and what covers each fact of the paper.

    The numbers are those of the drive; without --drive, of the paper's.
    """
    from drivegate.contracts.traceability import traced_checks, traced_facts
    from drivegate.drives.kinds import DEFAULT_DRIVE
    from drivegate_cases.drive.drive_document import load_drive

    checks = traced_checks(load_drive(DEFAULT_DRIVE if drive is None else drive))
    document = {"schema": SCHEMA, "checks": checks, "facts": traced_facts()}
    return Outcome(document, lambda console: _show(console, document))


def _show(console: Console, document: dict[str, Any]) -> None:
    from drivegate.output.console import plain, print_line, table

    listed = table(*_COLUMNS)
    for row in document["checks"]:
        listed.add_row(*(plain(row[key]) for key in _COLUMNS))
    console.print(listed)
    covered = table("fact", "stated", "checks", "tests", "figures")
    for fact in document["facts"]:
        by = fact["covered_by"]
        covered.add_row(
            plain(fact["id"]),
            plain(fact["title"]),
            plain(", ".join(by["checks"])),
            plain(str(len(by["properties"]) or "")),
            plain(", ".join(name.replace("_", " ") for name in by["figures"])),
        )
    console.print(covered)
    print_line(console, "next: drivegate check CANDIDATE applies them; --json prints more", "dim")
