"""``drivegate report``: the reports of a result, made again from its document."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import folder_option, json_option

if TYPE_CHECKING:
    from rich.console import Console

SCHEMA = 1
DEFAULT_OUTPUT = "drivegate-report"


@click.command("report")
@click.argument("file", type=click.Path(path_type=Path), metavar="FILE")
@click.option(
    "--format",
    "formats",
    metavar="NAME",
    multiple=True,
    help="A report to make: an installed one by the name of its entry point, junit or markdown; may be given "
    "again. By default all.",
)
@folder_option(DEFAULT_OUTPUT, "Folder of the reports.")
@json_option
def command(file: Path, formats: tuple[str, ...], output: Path) -> Outcome:
    """Make the reports of the result in FILE, a result.json, again.

    The folder gets the result and its counterexamples too. The exit code is 0 when all reports are made, whatever
    the result's verdict.
    """
    from drivegate.output.report_folder import ReportFolder
    from drivegate.output.result_reports import read_result, report_formats, write_reports_again
    from drivegate.results.result import alteration_of

    chosen = report_formats(formats)
    result = read_result(file)
    with ReportFolder(output) as folder:
        written = write_reports_again(result, file, folder.staging, chosen, output)
        folder.commit()
    document = {
        "schema": SCHEMA,
        "kind": "reports",
        "candidate": result["candidate"]["name"],
        "verdict": result["verdict"],
        "formats": list(chosen),
        "alteration": alteration_of(result),
        "pages": [str(output / page) for page in written.pages.values()],
    }
    return Outcome(document, lambda console: _show(console, document))


def _show(console: Console, document: dict[str, Any]) -> None:
    from drivegate.output.console import plain, print_line, verdict_text

    heading = plain(f"{document['candidate']}: ")
    heading.append_text(verdict_text(document["verdict"]))
    if document["alteration"]:
        heading.append(f", but the result {document['alteration']}", "bold red")
    console.print(heading)
    for page in document["pages"]:
        print_line(console, f"report: {page}")
