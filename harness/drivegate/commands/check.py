"""``drivegate check``: the gate."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from drivegate.commands.completion import complete_candidate, complete_checks
from drivegate.commands.conduct import Outcome
from drivegate.commands.options import (
    WholeNumber,
    bounded,
    drive_option,
    effort_option,
    folder_option,
    isolation_options,
    json_flag,
    named_drive,
    workers_option,
)
from drivegate.commands.stated_options import CheckCommand, again, is_stated
from drivegate.output.failure import complain, failure_of
from drivegate.output.streams import write_to

if TYPE_CHECKING:
    from drivegate.studies.check.checked import Checked

DEFAULT_OUTPUT = "drivegate-report"


@click.command("check", cls=CheckCommand)
@click.argument("candidates", nargs=-1, metavar="[CANDIDATE]...", shell_complete=complete_candidate)
@folder_option(DEFAULT_OUTPUT, "Folder of the report.")
@drive_option
@effort_option("Number of scenarios that are drawn.")
@click.option(
    "--seed", type=WholeNumber(0, 2**63 - 1), default=0, show_default=True, help="Seed of the search."
)
@workers_option
@isolation_options
@click.option(
    "--max-time",
    type=bounded(0.0, above=True, unit="seconds"),
    metavar="SECONDS",
    help="Begin no more work after this time; what is left is inconclusive, or not yet witnessed.",
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
    "--requirements",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="TOML file of your own requirements; by default the one that the candidate's manifest names.",
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
@click.option(
    "--contested",
    type=click.Choice(["pass", "fail"]),
    default="pass",
    show_default=True,
    help="Whether a failure counts that no known good controller avoids in the same scenario.",
)
@click.option(
    "--only",
    multiple=True,
    metavar="CHECKS",
    shell_complete=complete_checks,
    help="Judge these checks alone, such as CNV-2,CNV-3 or a family such as CNV; may be given again.",
)
@click.option(
    "-x", "--stop-at-first", is_flag=True, help="Begin no more work after the first failure that counts."
)
@click.option(
    "--last-failed",
    is_flag=True,
    help="Judge what failed in the last report in DIR alone, its counterexamples first; all if nothing did.",
)
@click.option(
    "--watch",
    is_flag=True,
    help="Check again whenever a source changes: first what failed, then the rest; needs drivegate[watch].",
)
@click.option(
    "--coverage",
    is_flag=True,
    help="Show what the runs reach of the candidate's code; needs drivegate[coverage].",
)
@click.option(
    "--coverage-at-least",
    metavar="LINES[,BRANCHES]",
    help="Fail unless the runs reach these percentages; counts like --coverage.",
)
@click.option(
    "--sanitize",
    metavar="NAMES",
    help="Fail on what sanitizers report: address, undefined, float, with commas between them.",
)
@click.option("-q", "--quiet", is_flag=True, help="Print failed checks and the last line alone.")
@json_flag(exposed=True)
def command(
    candidates: tuple[str, ...],
    output: Path,
    drive: str | None,
    effort: str,
    seed: int,
    workers: int | None,
    max_time: float | None,
    search: bool,
    corpus: Path | None,
    requirements: Path | None,
    waivers: Path | None,
    baseline: Path | None,
    fail_on: Literal["required", "advisory"],
    contested: Literal["pass", "fail"],
    only: tuple[str, ...],
    stop_at_first: bool,
    last_failed: bool,
    watch: bool,
    coverage: bool,
    coverage_at_least: str | None,
    sanitize: str | None,
    quiet: bool,
    as_json: bool,
) -> Outcome:
    """Check every CANDIDATE: apply all checks, search for a scenario that breaks one, and write a report.

    A CANDIDATE is a class in Python (file.py:Class or module:Class), a NumbaController (file.py:name), C, C++ or a
    shared library (file.c, file.cpp, file.so, also from Rust), an image for a Cortex-M (file.elf), an FMU (file.fmu),
    any program that answers in lines of JSON (exec:command), a manifest (candidate.toml) for one of these, or the name
    of a controller that is included (reference, published, initial, faulty:NAME, design:NAME, near:NAME) or is
    installed. inner:pi:candidate runs any of these that answers with a current reference on a drive of duty ratios.

    Without a CANDIDATE it is candidate.toml in this folder. The table [check] of a manifest may state drive, effort,
    seed, corpus, waivers, baseline, requirements, output, fail_on and contested; the command line wins.

    The exit code is 0 when all pass or are waived, 1 when one fails, 2 when one is refused, 3 after a fault of
    drivegate.
    """
    from drivegate.gate.options import CheckOptions
    from drivegate.studies.check.check_all import Records, check_all
    from drivegate.studies.check.checked import summary
    from drivegate.studies.check.inspection import read_inspection
    from drivegate.studies.check.part import Part

    options = CheckOptions(
        drive=named_drive(drive),
        drive_named=None if is_stated("drive") else drive,
        effort=effort,
        seed=seed,
        workers=workers,
        max_time=max_time,
        search=search,
        fail_on=fail_on,
        contested=contested,
    )
    inspection = read_inspection(coverage, coverage_at_least, sanitize)
    records = Records(corpus, waivers, baseline, requirements)
    reported: set[int] = set()

    def complain_again(all_checked: list[Checked]) -> None:
        for checked in all_checked:
            if checked.error is not None and id(checked.error) not in reported:
                reported.add(id(checked.error))
                failure = failure_of(checked.error)
                alone = len(all_checked) == 1
                complain(failure if alone else failure.about(checked.specification), checked.error)

    def show(all_checked: list[Checked]) -> None:
        if not _is_refused(all_checked):
            complain_again(all_checked)
            if not as_json and sys.stdout is not None:
                _show(all_checked, output, again(), quiet=quiet)

    def check_once(begin_with_failed: bool) -> Outcome:
        part = Part(only, stop_at_first, begin_with_failed)
        all_checked = check_all(
            candidates, output, options, records, part, inspection=inspection, quiet=quiet, show=show
        )
        if _is_refused(all_checked):
            assert all_checked[0].error is not None, "that is what refused means"
            raise all_checked[0].error
        complain_again(all_checked)
        exit_code = max(checked.exit_code for checked in all_checked)
        return Outcome(summary(all_checked), lambda _: None, exit_code)

    if not watch:
        return check_once(last_failed)
    if len(candidates) != 1 or as_json:
        raise click.UsageError("--watch takes one candidate, and does not go with --json")
    return _watched(candidates[0], output, check_once)


def _watched(specification: str, output: Path, check_once: Callable[[bool], Outcome]) -> Outcome:
    """Check one candidate again after every change, until somebody ends it."""
    from drivegate.studies.check.watch import changes_around, version_of, watch

    def checked(begin_with_failed: bool) -> int:
        try:
            code = check_once(begin_with_failed).exit_code
        except Exception as error:
            failure = failure_of(error)
            complain(failure, error)
            code = failure.exit_code
        write_to(sys.stderr, f"watching the sources of {specification}; Ctrl-C ends it\n")
        return code

    code = watch(checked, changes_around(specification, output), lambda: version_of(specification))
    return Outcome({}, lambda _: None, code)


def _is_refused(all_checked: list[Checked]) -> bool:
    """Return True if the only candidate has no result."""
    (first, *others) = all_checked
    return not others and first.error is not None and first.document is None


def _show(all_checked: list[Checked], output: Path, command_again: str, *, quiet: bool) -> None:
    from drivegate.output.console import console_for
    from drivegate.studies.check.display import show_checked, show_failures, show_last_line

    console = console_for(sys.stdout)
    for checked in all_checked:
        if checked.document is None:
            continue
        if quiet:
            show_failures(console, checked)
        else:
            show_checked(console, checked, command_again if len(all_checked) == 1 else None)
    show_last_line(console, all_checked, output)
