"""``drivegate replay``: run a counterexample again."""

from __future__ import annotations

from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import json_option

if TYPE_CHECKING:
    from rich.console import Console


@click.command("replay")
@click.argument("file", type=click.Path(path_type=Path), metavar="FILE")
@click.option(
    "--candidate",
    metavar="CANDIDATE",
    help="The candidate to run; by default the file's, if it comes with drivegate.",
)
@click.option(
    "--plot",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write a figure; the name ends in .png or .svg.",
)
@json_option
def command(file: Path, candidate: str | None, plot: Path | None) -> Outcome:
    """Run the counterexample in FILE again, and tell whether its check STILL FAILS or is FIXED.

    The exit code is 1 when it still fails, 0 when it is fixed or does not apply to the candidate.
    """
    from drivegate.output.trace_files import check_targets
    from drivegate.results.counterexample import read_counterexample

    stored = read_counterexample(file)
    check_targets(None, None, plot)

    from drivegate.candidates.fault import Fault
    from drivegate.studies.replay.replay import candidate_for, document_of, replayed

    resolved = candidate_for(stored, candidate)
    ended = replayed(stored, resolved)
    document = document_of(stored, resolved, ended)
    if plot is not None and not isinstance(ended, Fault):
        from drivegate.studies.replay.figure import draw

        title = f"{stored.check} {document['verdict']}: {resolved.name}, {stored.scenario.name}"
        draw(stored, ended, plot, title)
        document["files"] = [str(plot)]
    hint = _next_step(document, file, candidate)
    return Outcome(document, lambda console: _show(console, document, hint), document["exit_code"])


def _next_step(document: dict[str, Any], file: Path, candidate: str | None) -> str:
    from drivegate.studies.replay.replay import STILL_FAILS

    named = "" if candidate is None else f" --candidate {quote(candidate)}"
    again = f"drivegate replay {quote(str(file))}{named}"
    if document["verdict"] != STILL_FAILS:
        who = quote(candidate or document["candidate"]["name"])
        # A report's own folder is replaced by the next one, and is no place to keep anything.
        copied = f"mkdir -p corpus && cp {quote(str(file))} corpus/"
        return f"keep it in a corpus: {copied} && drivegate check {who} --corpus corpus"
    if document["fault"] is None and not document["files"]:
        return f"look at the signals: {again} --plot {document['check']}.svg"
    return f"change the controller, then {again}"


def _show(console: Console, document: dict[str, Any], hint: str) -> None:
    from drivegate.output.console import plain
    from drivegate.studies.replay.replay import FIXED

    name, fault = document["candidate"]["name"], document["fault"]
    good = document["verdict"] == FIXED
    console.print(
        plain(f"{document['check']} {document['verdict'].upper()}", "bold green" if good else "bold red")
    )
    console.print(plain(f"  {document['requirement']}"))
    console.print(plain(f"  then {_told(document['then'])}, by {document['found_with']['name']}"))
    if fault is not None:
        console.print(plain(f"  now  {fault['kind']}: {fault['message']}, by {name}"))
        for line in fault["traceback"].splitlines():
            console.print(plain(f"  {line}", "dim"))
    elif document["now"] is None:
        console.print(plain(f"  now  {document['reason']}; {name} ran"))
    else:
        console.print(plain(f"  now  {_told(document['now'])}, by {name}"))
        console.print(plain(f"  limit {document['limit']}; in {document['scenario']}, {_where(document)}"))
    for path in document["files"]:
        console.print(plain(f"written: {path}"))
    console.print(plain(f"next: {hint}", "dim"))


def _where(document: dict[str, Any]) -> str:
    if document["rows"] is not None:
        first, last = document["rows"]
        return f"row {last}" if first == last else f"rows {first} to {last}"
    start, end = document["window_s"]
    return f"{start:g} s to {end:g} s"


def _told(measured: dict[str, Any]) -> str:
    margin = measured["margin"]
    told = "margin –" if margin is None else f"margin {margin:+.4g}"
    return f"{told} ({measured['measured']})" if measured["measured"] else told
