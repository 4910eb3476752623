"""``drivegate cases``: the scenarios, operating points, sweeps, drive cycles and drives that come with drivegate."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import json_option

if TYPE_CHECKING:
    from rich.console import Console


@click.command("cases")
@json_option
def command() -> Outcome:
    """List the scenarios, operating points, sweeps, drive cycles and drives that are included."""
    from drivegate.studies.cases import cases_document, show_cases

    document = cases_document()

    def show(console: Console) -> None:
        show_cases(console, document)

    return Outcome(document, show)
