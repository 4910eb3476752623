"""A self-test on drawn drives on the console."""

from __future__ import annotations

from collections.abc import Mapping
from shlex import quote
from typing import TYPE_CHECKING, Any, Final

from drivegate.output.console import plain, table
from drivegate.output.progress import duration_in_words

if TYPE_CHECKING:
    from rich.console import Console

_MOST_NAMED: Final = 12
_PER_UNIT: Final = {
    "speed_range": "speeds",
    "emf": "EMF",
    "reactance": "reactance",
    "saliency": "saliency",
    "resistance": "resistance",
    "current_limit": "current limit",
    "power": "power",
    "mechanical_time": "J·ω/T, s",
}
"""Values that the table of failed drives has, as far as their kind has them, with their headings."""


def show_drives(console: Console, document: Mapping[str, Any]) -> None:
    """Print what fails and where, the shares, and how to go on."""
    _show_failed_drives(console, document)
    for failure in document["failures"]:
        _show_failure(console, failure)
    _show_faults(console, document)
    reference = document["reference"]
    words = (
        f"{document['candidate']} passes {_in_words(reference, 'drives')}; {document['rejected_draws']} more were "
        "drawn and set aside, since no controller can meet their rating"
    )
    console.print(plain(words, "green" if document["passed"] else "bold red"))
    if document["faults"]:
        console.print(plain(f"faults caught in {_in_words(document['trials'], 'trials')}"))
    took = duration_in_words(document["timing"]["seconds"])
    console.print(
        plain(f"{document['timing']['made']} results made now, in {took}; all are in {document['output']}")
    )
    console.print(plain(f"next: {_next_step(document)}", "dim"))


def _show_failed_drives(console: Console, document: Mapping[str, Any]) -> None:
    failed = [drive for drive in document["drives"] if not drive["passed"]]
    if not failed:
        return
    shown = [key for key in _PER_UNIT if key in failed[0]["per_unit"]]
    numbers = ("phases", "W", "V", *(_PER_UNIT[key] for key in shown))
    listed = table("drive", "fails", "EMF's shape", *numbers, right=numbers)
    for drive in failed:
        reasons = dict.fromkeys(
            reason
            for row in drive["seeds"]
            if not row["passed"]
            for reason in ([check["check"] for check in row["failed"]] or [row["verdict"]])
        )
        values = (drive["phases"], drive["rated_power_w"], drive["supply_voltage_v"])
        own = drive["per_unit"]
        cells = (*(f"{value:g}" for value in values), *(f"{own[key]:.3g}" for key in shown))
        named = (f"{drive['number']:03d}", ", ".join(reasons), drive["emf_shape"])
        listed.add_row(*map(plain, (*named, *cells)))
    console.print(listed)
    console.print(plain("V: half of the supply; the last columns are per unit", "dim"))


def _show_failure(console: Console, failure: Mapping[str, Any]) -> None:
    worst, count = failure["worst"], len(failure["numbers"])
    head = (
        f"{failure['reason']}: on {count} {'drive' if count == 1 else 'drives'}, {_named(failure['numbers'])}"
    )
    console.print(plain(head, "bold"))
    limit = f"; limit {worst['limit']}" if worst["limit"] else ""
    console.print(
        plain(f"  worst on drive {worst['number']:03d}, seed {worst['seed']}: {worst['measured']}{limit}")
    )
    if worst["facts"]:
        console.print(plain(f"  facts {worst['facts']}"))


def _show_faults(console: Console, document: Mapping[str, Any]) -> None:
    if not document["faults"]:
        return
    listed = table("fault", "check", "caught", "missed on drives", "does not apply on")
    for fault in document["faults"]:
        caught = f"{fault['count']} of {fault['of']}"
        idle = [int(number) for number in fault["does_not_apply_on"]]
        drives = (_named(numbers) or "–" for numbers in (fault["missed_on"], idle))
        listed.add_row(*map(plain, (fault["name"], fault["named_check"], caught, *drives)))
    console.print(listed)


def _in_words(share: Mapping[str, Any], unit: str) -> str:
    """Write a share with its interval."""
    if not share["of"]:
        return f"0 of 0 {unit}"
    low, high = (f"{100.0 * end:.3g}" for end in share["interval"])
    return (
        f"{share['count']} of {share['of']} {unit}, {100.0 * share['share']:.3g} % "
        f"(95 % interval {low} to {high} %)"
    )


def _named(numbers: list[int]) -> str:
    more = f" and {len(numbers) - _MOST_NAMED} more" if len(numbers) > _MOST_NAMED else ""
    return ", ".join(f"{number:03d}" for number in numbers[:_MOST_NAMED]) + more


def _next_step(document: Mapping[str, Any]) -> str:
    """State how to see more of what is worst; of a drive that passes, what it can do."""
    if document["failures"]:
        worst = document["failures"][0]["worst"]
        effort = "" if document["effort"] == "default" else f" --effort {document['effort']}"
        seed = f" --seed {worst['seed']}" if worst["seed"] else ""
        return f"drivegate check {document['candidate']} --drive {quote(worst['file'])}{effort}{seed}"
    missed = [(fault["name"], number) for fault in document["faults"] for number in fault["missed_on"]]
    files = {drive["number"]: drive["file"] for drive in document["drives"]}
    if missed:
        name, number = missed[0]
        return f"drivegate check faulty:{name} --drive {quote(files[number])}"
    return f"drivegate drive {quote(next(iter(files.values())))} shows what a drive can do"
