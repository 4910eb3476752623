"""``drivegate cases``: the scenarios, operating points, sweeps, drive cycles and drives that come with drivegate."""

from __future__ import annotations

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import json_option


@click.command("cases")
@json_option
def command() -> Outcome:
    """List the scenarios, operating points, sweeps, drive cycles and drives that are included."""
    from drivegate.studies.cases import cases_document, show_cases

    document = cases_document()
    return Outcome(document, lambda console: show_cases(console, document))
