"""The self-test on the console: the matrix of faults and checks, and every miss and false alarm in a sentence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

from rich.text import Text

from drivegate.output.console import plain, table, verdict_text
from drivegate.scenarios.facts import PLAIN_RUN
from drivegate_lab.selftest.matrix import DesignRow, FaultRow, LeastMargin, Matrix, detection_by_kind

if TYPE_CHECKING:
    from rich.console import Console

CAUGHT = "●"
MISSED = "✗"
ALSO = "·"


def show_matrix(console: Console, matrix: Matrix, drive: str | None = None) -> None:
    """Print the self-test; `drive` is what the user named."""
    _show_faults(console, matrix)
    _show_counterexamples(console, matrix)
    _show_kinds(console, matrix)
    _show_designs(console, matrix)
    problems = matrix.problems()
    for problem in problems:
        console.print(plain(problem, "bold red"))
    for remark in matrix.remarks():
        console.print(plain(remark, "yellow"))
    for row in matrix.faults:
        if not row.applies:
            console.print(plain(f"{row.name} does not apply: {row.idle_because}", "dim"))
    tried = [row for row in matrix.faults if row.applies]
    caught = sum(row.caught for row in tried)
    acquitted = sum(row.acquitted for row in matrix.designs)
    summary = (
        f"{caught} of {len(tried)} faults caught by the checks named for them, "
        f"{acquitted} of {len(matrix.designs)} checks of correct designs passed"
    )
    console.print(plain(summary, "bold red" if problems else "green"))
    if problems and matrix.faults:
        name = next(
            (row.name for row in matrix.faults if row.applies and not row.caught), matrix.faults[0].name
        )
        on_drive = "" if drive is None else f" --drive {quote(drive)}"
        words = f"next: drivegate check faulty:{name}{on_drive} shows every check and scenario"
        console.print(plain(words, "dim"))
    else:
        console.print(plain("next: drivegate checks lists the checks", "dim"))


def show_unfair(console: Console, document: Mapping[str, Any], kept: Sequence[Path]) -> None:
    """Print the fair scenarios in which no good controller meets a check, and where they are kept."""
    for row, path in zip(document["unfair"], kept, strict=True):
        sentence = f"{row['check']} is met by no controller in {path}: {row['candidate']}, {row['measured']}"
        console.print(plain(sentence, "bold red"))
    for row in document["met_by_a_witness"]:
        failed = f"{row['candidate']} on {row['drive']} fails {row['check']}"
        sentence = f"{failed}, which a witness meets there: {row['measured']}"
        console.print(plain(sentence, "yellow"))
    for fault in document["faults"]:
        console.print(plain(fault, "bold red"))
    count = len(document["unfair"])
    scenarios = "scenario" if count == 1 else "scenarios"
    words = f"{count} unfair {scenarios} in {document['runs']} runs of correct controllers"
    console.print(plain(words, "green" if document["passed"] else "bold red"))
    if kept:
        step = f"drivegate simulate {document['unfair'][0]['candidate']} --case {kept[0]} shows the first one"
    else:
        step = "--seeds N and --effort search further, --drives N on drawn drives"
    console.print(plain(f"next: {step}", "dim"))


def _show_faults(console: Console, matrix: Matrix) -> None:
    if not matrix.faults:
        return
    # A heading of two lines, so that twenty columns fit.
    used = [
        check for check in matrix.checks if any(check in (row.check, *row.failing) for row in matrix.faults)
    ]
    headings = {check: check.replace("-", " ") for check in used}
    listed = table("fault", *headings.values(), "runs", "facts", right=("runs", "facts"))
    for column in listed.columns[1 : len(used) + 1]:
        column.overflow, column.justify, column.min_width, column.max_width = "fold", "center", 3, 3
    for row in (row for row in matrix.faults if row.applies):
        slowest = row.slowest
        numbers = ("–", "–") if slowest is None else (str(slowest.runs), str(len(slowest.facts)))
        listed.add_row(plain(row.name), *(_mark(row, check) for check in used), *numbers)
    console.print(listed)
    console.print(
        plain(
            f"{CAUGHT} caught by the check named for the fault, {MISSED} missed by it, {ALSO} fails as well; "
            "runs to the first counterexample, and how many facts it has when made simpler",
            "dim",
        )
    )


def _show_counterexamples(console: Console, matrix: Matrix) -> None:
    caught = [(row, row.slowest) for row in matrix.faults if row.slowest is not None]
    if not caught:
        return
    listed = table("fault", "simplest counterexample")
    for row, catch in caught:
        listed.add_row(plain(row.name), plain(", ".join(catch.facts) or PLAIN_RUN))
    console.print(listed)


def _show_kinds(console: Console, matrix: Matrix) -> None:
    if not matrix.faults:
        return
    numbers = ("caught", "runs, median", "greatest", "facts, median", "greatest ")
    listed = table("kind of fault", *numbers, right=numbers)
    for row in detection_by_kind(matrix.faults):
        counts = (row.runs_median, row.runs_greatest, row.facts_median, row.facts_greatest)
        shown = ("–" if count is None else f"{count:g}" for count in counts)
        listed.add_row(plain(row.kind), f"{row.caught} of {row.faults}", *shown)
    console.print(listed)


def _mark(row: FaultRow, check: str) -> Text:
    if check == row.check:
        return Text(CAUGHT, style="green") if row.caught else Text(MISSED, style="bold red")
    return Text(ALSO if check in row.failing else "")


def _show_designs(console: Console, matrix: Matrix) -> None:
    if not matrix.designs:
        return
    listed = table(
        "correct design", "seed", "verdict", "least margin", "fails", "advised by", right=("seed",)
    )
    for row in matrix.designs:
        checks = (plain(", ".join(ids) or "–") for ids in (row.accused_by, row.advised_by))
        listed.add_row(plain(row.name), str(row.seed), verdict_text(row.verdict), plain(_least(row)), *checks)
    console.print(listed)
    counted = table("innocents", "accused", "least margin", right=("accused",))
    for kind in matrix.innocents():
        counted.add_row(plain(kind.kind), f"{kind.accused} of {kind.designs}", plain(_margin(kind.least)))
    console.print(counted)


def _least(row: DesignRow) -> str:
    return f"{_margin(row.least)}{', near by design' if row.near else ''}"


def _margin(least: LeastMargin | None) -> str:
    return "–" if least is None else f"{least.check} {least.margin:+.3f}"
