"""A counterexample that was run again on the console."""

from __future__ import annotations

from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

from drivegate.output.console import plain
from drivegate.studies.replay.replay import FIXED, NOT_REPRODUCED, STILL_FAILS

if TYPE_CHECKING:
    from rich.console import Console


def next_step(document: dict[str, Any], file: Path, candidate: str | None) -> str:
    """Tell what to do with a counterexample that still fails, or no longer does."""
    named = "" if candidate is None else f" --candidate {quote(candidate)}"
    again = f"drivegate replay {quote(str(file))}{named}"
    if document["verdict"] == NOT_REPRODUCED:
        return (
            f"what differs: drivegate check {quote(candidate or document['candidate']['name'])} --only DET-1"
        )
    if document["verdict"] != STILL_FAILS:
        who = quote(candidate or document["candidate"]["name"])
        # A report's own folder is replaced by the next one, and is no place to keep anything.
        copied = f"mkdir -p corpus && cp {quote(str(file))} corpus/"
        return f"keep it in a corpus: {copied} && drivegate check {who} --corpus corpus"
    if document["fault"] is None and not document["files"]:
        return f"look at the signals: {again} --plot {document['check']}.svg"
    return f"change the controller, then {again}"


def show_replay(console: Console, document: dict[str, Any], hint: str) -> None:
    """Print what was measured then and now."""
    name, fault = document["candidate"]["name"], document["fault"]
    good = document["verdict"] == FIXED
    console.print(
        plain(f"{document['check']} {document['verdict'].upper()}", "bold green" if good else "bold red")
    )
    console.print(plain(f"  {document['requirement']}"))
    console.print(plain(f"  then {_margin_text(document['then'])}, by {document['found_with']['name']}"))
    if fault is not None:
        console.print(plain(f"  now  {fault['kind']}: {fault['message']}, by {name}"))
        for line in fault["traceback"].splitlines():
            console.print(plain(f"  {line}", "dim"))
    elif document["now"] is None:
        console.print(plain(f"  now  {document['reason']}; {name} ran"))
    else:
        console.print(plain(f"  now  {_margin_text(document['now'])}, by {name}"))
        console.print(plain(f"  limit {document['limit']}; in {document['scenario']}, {_where(document)}"))
    if document["remark"]:
        console.print(plain(f"  {document['remark']}", "bold red"))
    for sentence in document["account"]:
        console.print(plain(f"  {sentence}"))
    for path in document["files"]:
        console.print(plain(f"written: {path}"))
    console.print(plain(f"next: {hint}", "dim"))


def _where(document: dict[str, Any]) -> str:
    if document["rows"] is not None:
        first, last = document["rows"]
        return f"row {last}" if first == last else f"rows {first} to {last}"
    start, end = document["window_s"]
    return f"{start:g} s to {end:g} s"


def _margin_text(measured: dict[str, Any]) -> str:
    margin = measured["margin"]
    text = "margin –" if margin is None else f"margin {margin:+.4g}"
    return f"{text} ({measured['measured']})" if measured["measured"] else text
