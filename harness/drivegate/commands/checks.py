"""``drivegate checks``: what is required of a candidate."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import json_option

if TYPE_CHECKING:
    from rich.console import Console

SCHEMA = 1


@click.command("checks")
@json_option
def command() -> Outcome:
    """List the checks with their requirements, sources and limits."""
    from drivegate.catalogue import CHECKS

    keys = ("id", "requirement", "source", "subject", "level", "limit", "scenarios")
    rows = [{key: getattr(check, key) for key in keys} for check in CHECKS]
    return Outcome({"schema": SCHEMA, "checks": rows}, lambda console: _show(console, rows))


def _show(console: Console, rows: list[dict[str, Any]]) -> None:
    from drivegate.console import plain, table

    listed = table("id", "level", "subject", "source", "requirement", "limit")
    for row in rows:
        listed.add_row(
            *(plain(row[key]) for key in ("id", "level", "subject", "source", "requirement", "limit"))
        )
    console.print(listed)
    console.print(plain("next: drivegate check CANDIDATE applies them", "dim"))
