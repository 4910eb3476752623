"""``drivegate check``: the gate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from drivegate.commands.conduct import ExitCode, Outcome, complain, failure_of
from drivegate.commands.options import bounded, json_option
from drivegate_cases.documents.wording import one_line

if TYPE_CHECKING:
    from rich.console import Console

    from drivegate.studies.check.check_all import Checked

SCHEMA = 1
DEFAULT_OUTPUT = "drivegate-report"


@click.command("check")
@click.argument("candidates", nargs=-1, required=True, metavar="CANDIDATE...")
@click.option(
    "--output",
    type=click.Path(path_type=Path),
    default=DEFAULT_OUTPUT,
    show_default=True,
    metavar="DIR",
    help="Folder of the report.",
)
@click.option(
    "--effort",
    type=click.Choice(["quick", "default", "nightly"]),
    default="default",
    show_default=True,
    help="Number of scenarios that are drawn.",
)
@click.option(
    "--seed", type=click.IntRange(0, 2**63 - 1), default=0, show_default=True, help="Seed of the search."
)
@click.option(
    "--workers", type=click.IntRange(1, 1024), help="Processes; by default as many as there are processors."
)
@click.option(
    "--max-time",
    type=bounded(0.0, above=True),
    metavar="SECONDS",
    help="Begin no more work after this time; what is left is inconclusive.",
)
@click.option(
    "--search/--no-search",
    default=True,
    show_default=True,
    help="Climb toward small margins, or draw at random throughout.",
)
@click.option(
    "--corpus",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Folder of counterexamples, JSON files, that are run again after the fixed scenarios.",
)
@click.option(
    "--waivers",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="TOML file of failures that are accepted until a day.",
)
@click.option(
    "--baseline",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="An earlier result.json that margins are compared with.",
)
@click.option(
    "--fail-on",
    type=click.Choice(["required", "advisory"]),
    default="required",
    show_default=True,
    help="Least level of a check whose failure fails the candidate.",
)
@json_option
def command(
    candidates: tuple[str, ...],
    output: Path,
    effort: str,
    seed: int,
    workers: int | None,
    max_time: float | None,
    search: bool,
    corpus: Path | None,
    waivers: Path | None,
    baseline: Path | None,
    fail_on: str,
) -> Outcome:
    """Check every CANDIDATE: apply all checks, search for a scenario that breaks one, and write a report.

    A CANDIDATE is a built-in or installed controller's name, module:Class, file.py:Class or a manifest.
    The exit code is 0 when all pass or are waived, 1 when one fails, 2 when one is refused, 3 after a fault of
    drivegate.
    """
    from drivegate.studies.check.check_all import Effort, Records, check_all

    how_much = Effort(effort, seed, workers, max_time, search, fail_on)
    records = Records(corpus, waivers, baseline)
    all_checked = check_all(candidates, output, how_much, _summary, records)
    if len(all_checked) == 1 and all_checked[0].error is not None and all_checked[0].document is None:
        raise all_checked[0].error
    for checked in all_checked:
        if checked.error is not None:
            failure = failure_of(checked.error)
            about = "" if len(all_checked) == 1 else f"{one_line(checked.specification)}: "
            complain(replace(failure, message=f"{about}{failure.message}"), checked.error)

    def show(console: Console) -> None:
        from drivegate.studies.check.display import show_checked

        for checked in all_checked:
            if checked.document is not None:
                show_checked(console, checked)

    return Outcome(_summary(all_checked), show, max(map(_exit_code, all_checked)))


def _summary(all_checked: Sequence[Checked]) -> dict[str, Any]:
    """Make the document about all candidates: of a single one, its result."""
    results = [_entry(checked) for checked in all_checked]
    if len(results) == 1:
        return results[0]
    # A fault of drivegate (3) wins over a refusal (2), and that over a failure (1).
    worst = max(_exit_code(checked) for checked in all_checked)
    return {"schema": SCHEMA, "kind": "checks", "exit_code": worst, "results": results}


def _entry(checked: Checked) -> dict[str, Any]:
    if checked.error is None and checked.document is not None:
        return checked.document
    named = {"candidate": {"specification": checked.specification}}
    return (checked.document or named) | (
        {} if checked.error is None else failure_of(checked.error).document()
    )


def _exit_code(checked: Checked) -> int:
    judged = ExitCode.PASSED if checked.document is None else checked.document["exit_code"]
    return int(max(judged, ExitCode.PASSED if checked.error is None else failure_of(checked.error).exit_code))
