"""``drivegate checks``: what is required of a candidate, why, and what exercises it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import json_option

if TYPE_CHECKING:
    from rich.console import Console

SCHEMA = 1

_COLUMNS = ("id", "level", "subject", "source", "requirement", "limit")


@click.command("checks")
@json_option
def command() -> Outcome:
    """List the checks with their requirements, sources and limits, and what covers each fact of the paper."""
    from drivegate.checks.traceability import traced_checks, traced_facts

    document = {"schema": SCHEMA, "checks": traced_checks(), "facts": traced_facts()}
    return Outcome(document, lambda console: _show(console, document))


def _show(console: Console, document: dict[str, Any]) -> None:
    from drivegate.output.console import plain, table

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
    console.print(plain("next: drivegate check CANDIDATE applies them; --json tells more", "dim"))
