"""``drivegate checks``: what is required of a candidate, why, and what exercises it."""

from __future__ import annotations

from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

import click

from drivegate.commands.completion import complete_checks
from drivegate.commands.conduct import Outcome
from drivegate.commands.options import drive_option, json_option, named_drive
from drivegate.commands.stated_options import own_drive

if TYPE_CHECKING:
    from rich.console import Console

SCHEMA = 1

_EXPLAINED = ("requirement", "limit", "formula", "scenarios", "why")
_COLUMNS = ("id", "level", "subject", "source", "requirement", "limit")


@click.command("checks")
@click.argument("names", nargs=-1, metavar="[CHECK]...", shell_complete=complete_checks)
@drive_option
@click.option(
    "--requirements",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="TOML file of your own requirements, which are listed after the checks.",
)
@json_option
def command(names: tuple[str, ...], drive: str | None, requirements: Path | None) -> Outcome:
    """List the checks with their requirements, sources and limits, and what covers each fact of the paper.

    With a CHECK such as STP-1, or a family such as STP, print all of it: requirement, limit on the drive, formula of
    the margin and likely causes of a failure. The numbers are those of the drive; without --drive, of the one that
    candidate.toml in this folder states, else of the paper's, or of the default drive of the CHECK, or for
    --requirements of the drive of duty ratios.
    """
    if names and requirements is not None:
        raise click.UsageError("--requirements lists a whole file; leave the CHECK out, or --requirements")
    if names:
        return _explained(names, drive)
    from drivegate.candidates.declaration import Declaration
    from drivegate.contracts.traceability import traced_checks, traced_facts
    from drivegate.drives.kinds import DEFAULT_DRIVE, DEFAULT_DRIVES
    from drivegate.gate.own_requirements import require_fitting
    from drivegate_cases.drive.drive_document import load_drive
    from drivegate_cases.requirements.file import read_requirements

    own = Declaration(requirements=None if requirements is None else read_requirements(requirements))
    usual = DEFAULT_DRIVE if requirements is None else DEFAULT_DRIVES["duty"]
    mine = own_drive() if drive is None else None
    chosen = mine or load_drive(drive or usual)
    require_fitting(own, chosen)
    checks = traced_checks(chosen, own)
    document = {"schema": SCHEMA, "checks": checks, "facts": traced_facts()}
    return Outcome(document, lambda console: _show(console, document, "" if mine else " CANDIDATE"))


def _explained(names: tuple[str, ...], drive: str | None) -> Outcome:
    from drivegate.studies.checks import explained_checks

    own = own_drive() if drive is None else None
    checks = explained_checks(names, named_drive(drive), own)
    is_own = own is not None and all(row["drive"] == own.name for row in checks)
    document = {"schema": SCHEMA, "checks": checks}

    def show(console: Console) -> None:
        from drivegate.output.console import print_line

        for row in checks:
            print_line(console, f"{row['id']} on {row['drive']} ({row['level']})", "bold")
            for key in _EXPLAINED:
                print_line(console, f"  {key}: {row[key]}")
            if row["not_applicable"]:
                hint = f"; it applies on {row['applies_on']}" if row["applies_on"] else ""
                print_line(console, f"  not applicable on {row['drive']}: {row['not_applicable']}{hint}")
            for cause in row["likely_causes"]:
                print_line(console, f"  likely cause: {cause}")
        only = ",".join(dict.fromkeys(row["id"] for row in checks))
        # Checks that apply nowhere together are named without a drive.
        others = {row["applies_on"] for row in checks}
        other = next(iter(others)) if len(others) == 1 else None
        chosen = drive if other is None else other
        drive_words = "" if chosen is None else f" --drive {quote(chosen)}"
        candidate = "" if is_own else " CANDIDATE"
        print_line(console, f"next: drivegate check{candidate} --only {only}{drive_words}", "dim")

    return Outcome(document, show)


def _show(console: Console, document: dict[str, Any], candidate: str) -> None:
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
    print_line(console, f"next: drivegate check{candidate} applies them; --json prints more", "dim")
