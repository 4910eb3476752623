"""``drivegate schema``: the JSON Schema of a file that users write."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import json_option

if TYPE_CHECKING:
    from rich.console import Console

NAMES = ("drive", "scenario", "candidate", "campaign", "waivers", "requirements")


@click.command("schema")
@click.argument("name", type=click.Choice(NAMES), metavar="NAME")
@json_option
def command(name: str) -> Outcome:
    """Print the JSON Schema of a kind of file, by which an editor completes and checks it.

    Templates name theirs in their first line, such as '#:schema schemas/candidate.schema.json'.
    """
    from drivegate.commands.file_schemas import SCHEMAS

    schema = SCHEMAS[name]()
    return Outcome(schema, lambda console: _show(console, schema))


def _show(console: Console, schema: dict[str, Any]) -> None:
    """Print it as it is, whatever the width of the terminal."""
    console.out(json.dumps(schema, indent=2, ensure_ascii=False), highlight=False)
