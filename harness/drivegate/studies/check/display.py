"""The result of a check on the console."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from shlex import quote
from typing import Any, Final

from rich.console import Console
from rich.text import Text

from drivegate.output.causes import account_of, causes_of, first_to_mend, likely_causes_of
from drivegate.output.console import ADVISED, STYLES, plain, print_line, table, verdict_text
from drivegate.output.explanations import by_urgency, distinct_faults, in_runs, unjudged_in_words
from drivegate.output.result_file import counterexample_name, fault_scenario_name
from drivegate.output.wording import (
    drive_in_words,
    drive_option,
    printed_margin,
    runs_in_short,
    scenario_in_short,
)
from drivegate.results.result import NOT_WITNESSED, counted_levels, witness_in_words
from drivegate.scenarios.facts import facts_in_short
from drivegate.studies.check.checked import Checked

COVERAGE_PAGE: Final = "coverage/index.html"
"""The annotated sources, in the report's folder."""
QUIET_VERDICTS: Final = ("pass", "not applicable", "waived", "inconclusive")
"""Verdicts of checks that a quiet run does not print."""
_UNCOUNTED: Final = {
    "contested": "no known good controller meets {them} in the same {scenario} either",
    NOT_WITNESSED: "the check ended before known good controllers were run there",
}


def show_checked(console: Console, checked: Checked, again: str | None = None) -> None:
    """Print the verdict on each check, what failed and where the report is.

    `again` is the command line that checks the same again; by default, the candidate's on its drive.
    """
    document, folder = checked.document, checked.folder
    assert document is not None, "only a candidate with a result is shown"
    for fault, count in distinct_faults(document["faults"]):
        place = document["faults"].index(fault) + 1
        _show_fault(console, fault, count, None if folder is None else folder / fault_scenario_name(place))
    if left := unjudged_in_words(document):
        print_line(console, f"  {left}", "bold")
    checks = by_urgency(document["checks"])
    failed = [check for check in checks if check["counterexample"] is not None]
    if failed:
        for cause in causes_of(document):
            print_line(console, cause, "bold red")
        for words in likely_causes_of(document):
            print_line(console, words, "bold")
    _show_uncounted(console, document)
    for remark in document.get("remarks", ()):
        print_line(console, f"remark: {remark}")
    show_code_coverage(console, document, folder)
    print_line(console, f"on the drive {drive_in_words(document['drive'])}", "dim")
    listed = table("check", "level", "verdict", "margin", "message", right=("margin",))
    counted = counted_levels(document.get("fail_on"))
    for check in checks:
        verdict = verdict_text(check["verdict"], counts=check["level"] in counted)
        margin = printed_margin(document, check)
        listed.add_row(plain(check["id"]), plain(check["level"]), verdict, margin, plain(check["message"]))
    console.print(listed)
    if document["baseline"]:
        compared = table("against the baseline", "level", "verdict", "message")
        for entry in document["baseline"]:
            verdict = verdict_text(entry["verdict"])
            compared.add_row(plain(entry["check"]), plain(entry["level"]), verdict, plain(entry["message"]))
        console.print(compared)
    for check in failed:
        _show_counterexample(console, document, check, folder)
    if folder is not None:
        print_line(console, f"next: {_next_step(checked, folder, again)}", "dim")


def _show_uncounted(console: Console, document: dict[str, Any]) -> None:
    """Print the failures that do not count, since no witness meets the requirement, or none was run."""
    for verdict, because in _UNCOUNTED.items():
        names = [check["id"] for check in document["checks"] if check["verdict"] == verdict]
        if names:
            them, scenario, rest = (
                ("it", "scenario", "it does") if len(names) == 1 else ("them", "scenarios", "they do")
            )
            reason = because.format(them=them, scenario=scenario)
            print_line(
                console, f"{verdict}: {', '.join(names)}: {reason}, so {rest} not count", "bold yellow"
            )


def show_code_coverage(console: Console, document: dict[str, Any], folder: Path | None) -> None:
    """Print what the runs reached of the candidate's code, where that was counted."""
    section = document.get("code_coverage")
    if section is not None:
        is_short = any(
            count["at_least_percent"] is not None
            and 100.0 * count["reached"] < count["at_least_percent"] * count["total"]
            for count in (section["lines"], section["branches"])
        )
        where = "" if folder is None else f"; {folder / COVERAGE_PAGE}"
        print_line(console, f"coverage: {section['message']}{where}", "bold red" if is_short else "")


def _show_fault(console: Console, fault: dict[str, Any], count: int, file: Path | None) -> None:
    print_line(console, f"{fault['kind']}{in_runs(count)}: {fault['message']}", "bold red")
    if fault["time_s"] is not None:
        print_line(console, f"  in step {fault['step']}, at {fault['time_s']:g} s")
    if fault.get("scenario") is not None:
        print_line(console, f"  in {scenario_in_short(fault['scenario'])}")
        if file is not None:
            print_line(console, f"  file {file}")
    for line in fault["traceback"].splitlines():
        print_line(console, f"  {line}", "dim")


def _show_counterexample(
    console: Console, document: dict[str, Any], check: dict[str, Any], folder: Path | None
) -> None:
    outcome = "fails" if check["verdict"] == "fail" else f"fails, {check['verdict']}"
    style = "bold" if check["level"] == "required" else STYLES[ADVISED]
    print_line(console, f"{check['id']} {outcome} ({check['level']}): {check['requirement']}", style)
    measured = check["measured"] if check["found"] is None else check["found"]["measured"]
    print_line(console, f"  measured {measured}; limit {check['limit']}")
    if check.get("witness") is not None:
        print_line(console, f"  {witness_in_words(check['witness'])}")
    print_line(console, f"  in {scenario_in_short(check['counterexample'])}")
    print_line(console, f"  facts {facts_in_short(check['counterexample'])}")
    for sentence in account_of(document, check):
        print_line(console, f"  {sentence}")
    if folder is not None:
        print_line(console, f"  file {folder / counterexample_name(check['id'])}")


def _next_step(checked: Checked, folder: Path, again: str | None) -> str:
    specification, document = quote(checked.specification), checked.document
    assert document is not None, "only a candidate with a result is shown"
    plain = f"drivegate check {specification}{drive_option(document)}"
    first = first_to_mend(document)
    if first is not None:
        file = str(folder / counterexample_name(first["id"]))
        return f"drivegate replay {quote(file)} --candidate {specification} --plot {first['id']}.svg"
    if document["faults"]:
        kind = document["faults"][0]["kind"]
        return f"mend what is named first ({kind}), then {again or plain}"
    if any(check["verdict"] == NOT_WITNESSED for check in document["checks"]):
        # The folder of one among several candidates is not the one that the command line has.
        return (
            f"{again or f'{plain} --output {quote(str(folder))}'} --last-failed runs known good controllers"
        )
    if document.get("focus") is not None or document.get("incomplete"):
        return f"the whole check: {again or plain}"
    if document["effort"] == "quick":
        return "open the report; --effort default draws nine times as many scenarios"
    return "open the report; drivegate checks lists what was required"


def show_failures(console: Console, checked: Checked) -> None:
    """Print a line for each check that fails, and for each kind of fault."""
    document = checked.document
    assert document is not None, "only a candidate with a result is shown"
    counted = counted_levels(document.get("fail_on"))
    for fault, count in distinct_faults(document["faults"]):
        print_line(console, f"{fault['kind']}{in_runs(count)}: {fault['message']}", "bold red")
    show_code_coverage(console, document, checked.folder)
    for check in by_urgency(document["checks"]):
        if check["verdict"] in QUIET_VERDICTS:
            continue
        line = plain(f"{check['id']} ")
        line.append_text(verdict_text(check["verdict"], counts=check["level"] in counted))
        margin = printed_margin(document, check)
        line.append_text(
            plain(f" ({check['level']}), margin {margin}: {check['measured'] or check['message']}")
        )
        console.print(line)


def show_last_line(console: Console, all_checked: Sequence[Checked], output: Path) -> None:
    """Print what has become of all candidates on one line."""
    line = plain("")
    for number, checked in enumerate(all_checked):
        line.append("; " if number else "")
        line.append_text(_ending(checked, alone=len(all_checked) == 1))
    seconds = sum(
        checked.document["timing"].get("seconds", 0.0) for checked in all_checked if checked.document
    )
    pages = all_checked[0].pages
    report: Path | str = pages[0] if len(all_checked) == 1 and pages else output
    if all(checked.folder is None for checked in all_checked):
        report = "none"
    line.append_text(plain(f", {seconds:.0f} s, report: {report}"))
    console.print(line)


def _ending(checked: Checked, *, alone: bool) -> Text:
    if checked.document is None:
        ending = plain(f"{checked.specification}: ")
        ending.append_text(plain("refused" if checked.exit_code == 2 else "no result", "bold red"))
        return ending
    ending = plain(f"{checked.document['candidate']['name']}: ")
    ending.append_text(verdict_text(checked.document["verdict"]))
    if alone:
        ending.append_text(plain(f", {runs_in_short(checked.document)}"))
    return ending
