"""The result of a check on the console."""

from __future__ import annotations

from shlex import quote
from typing import TYPE_CHECKING, Any

from drivegate.output.console import plain, table, verdict_text
from drivegate.output.distinct_faults import distinct_faults, in_runs
from drivegate.output.result_file import counterexample_name
from drivegate.results.wording import printed_margin, runs_in_short

if TYPE_CHECKING:
    from pathlib import Path

    from rich.console import Console

    from drivegate.studies.check.check_all import Checked


def show_checked(console: Console, checked: Checked) -> None:
    """Print the verdict on each check, what failed and where the report is."""
    document, folder = checked.document, checked.folder
    assert document is not None, "only a candidate with a result is shown"
    assert folder is not None, "a result has its folder"
    listed = table("check", "level", "verdict", "margin", "message", right=("margin",))
    for check in document["checks"]:
        verdict, margin = verdict_text(check["verdict"]), printed_margin(document, check)
        listed.add_row(plain(check["id"]), plain(check["level"]), verdict, margin, plain(check["message"]))
    console.print(listed)
    if document["baseline"]:
        _show_comparisons(console, document["baseline"])
    for fault, count in distinct_faults(document["faults"]):
        _show_fault(console, fault, count)
    failed = [check for check in document["checks"] if check["counterexample"] is not None]
    for check in failed:
        _show_counterexample(console, check, folder)
    heading = plain(f"{document['candidate']['name']}: ")
    heading.append_text(verdict_text(document["verdict"]))
    heading.append(f", {runs_in_short(document)}")
    console.print(heading)
    for page in checked.pages or (folder,):
        console.print(plain(f"report: {page}"))
    console.print(plain(f"next: {_next_step(checked.specification, failed, folder)}", "dim"))


def _show_comparisons(console: Console, entries: list[dict[str, Any]]) -> None:
    listed = table("against the baseline", "level", "verdict", "message")
    for entry in entries:
        verdict = verdict_text(entry["verdict"])
        listed.add_row(plain(entry["check"]), plain(entry["level"]), verdict, plain(entry["message"]))
    console.print(listed)


def _show_fault(console: Console, fault: dict[str, Any], count: int) -> None:
    console.print(plain(f"{fault['kind']}{in_runs(count)}: {fault['message']}", "bold red"))
    if fault["time_s"] is not None:
        console.print(plain(f"  in step {fault['step']}, at {fault['time_s']:g} s"))
    for line in fault["traceback"].splitlines():
        console.print(plain(f"  {line}", "dim"))


def _show_counterexample(console: Console, check: dict[str, Any], folder: Path) -> None:
    outcome = "fails" if check["verdict"] == "fail" else f"fails, {check['verdict']}"
    console.print(plain(f"{check['id']} {outcome} ({check['level']}): {check['requirement']}", "bold"))
    measured = check["measured"] if check["found"] is None else check["found"]["measured"]
    console.print(plain(f"  measured {measured}; limit {check['limit']}"))
    console.print(plain(f"  in {scenario_in_short(check['counterexample'])}"))
    console.print(plain(f"  file {folder / counterexample_name(check['id'])}"))


def _next_step(specification: str, failed: list[dict[str, Any]], folder: Path) -> str:
    required = [check for check in failed if check["level"] == "required" and check["verdict"] in _TO_BE_MET]
    if not required:
        return "open the report; drivegate checks lists what was required"
    check = required[0]["id"]
    file = str(folder / counterexample_name(check))
    return f"drivegate replay {quote(file)} --candidate {quote(specification)} --plot {check}.svg"


def scenario_in_short(scenario: dict[str, Any]) -> str:
    """Tell a scenario in one line."""
    if scenario.get("kind") == "script":
        return f"{scenario['name']}: a script of {len(scenario['rows'])} rows"
    load = scenario["load"]
    parts = [f"{scenario['duration_s']:g} s", f"{_values(scenario['speed_rpm'])} rpm", _load(load)]
    if "supply_v" in scenario:
        parts.append(f"supply {_values(scenario['supply_v'])} V")
    parts += [
        f"{key} × {value:g}"
        for key, value in scenario.get("scales", {}).items()
        if key in _FACTORS and value != 1.0
    ]
    added = scenario.get("scales", {}).get("friction_added_n_m", 0.0)
    if added:
        parts.append(f"{added:g} N·m of friction added")
    return f"{scenario['name']}: {', '.join(parts)}"


_TO_BE_MET = ("fail", "waiver expired")
_FACTORS = ("resistance", "inductance", "emf_constant")


def _values(profile: list[list[float]]) -> str:
    values = [value for _, value in profile]
    distinct = [value for index, value in enumerate(values) if index == 0 or value != values[index - 1]]
    return " → ".join(f"{value:g}" for value in distinct)


def _load(load: dict[str, Any]) -> str:
    size = {"torque_nm": "N·m", "power_w": "W"}
    told = [f"{load[key]:g} {unit}" for key, unit in size.items() if key in load]
    factor = f" × {_values(load['factor'])}" if "factor" in load else ""
    return " ".join(["load", load["kind"].replace("_", " "), *told]) + factor
