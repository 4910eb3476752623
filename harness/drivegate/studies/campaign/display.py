"""A finished campaign on the console."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from shlex import quote
from typing import Any, Final

import numpy as np
from rich.console import Console
from rich.table import Table

from drivegate.output.console import number, plain, print_ending, print_line, table
from drivegate_cases.documents.wording import significant

_WORDS: Final = ("check", "level")
_MARGINS: Final = ("worst margin", "5 %", "median")
"""Columns of the margins that are shown."""
_BLANK: Final = dict.fromkeys((*_MARGINS, "worst run"), "")
_UNBOUNDED: Final = 10_000
_SPARED: Final = ("5 %", "median", "probability", "level", "worst run")
"""Columns that a narrow console goes without, the first of them first."""


def show_campaign(console: Console, document: dict[str, Any]) -> None:
    """Print a table for each candidate, its first faults, and where to go on."""
    for candidate in document["candidates"]:
        verdicts = ", ".join(f"{count} {verdict}" for verdict, count in candidate["verdicts"].items())
        rows = _rows(document, candidate)
        console.print(_fitting(console, f"{candidate['name']}: {verdicts}", rows))
        for fault in candidate["first_faults"]:
            print_line(
                console, f"{fault['verdict']}: first in run {fault['run']}, {fault['file']}", "bold red"
            )
    print_line(console, f"results: {document['output']}")
    for page in document["pages"]:
        contents = "has the margins of all runs, and the commands that run the worst of them again"
        print_line(console, f"next: {page} {contents}", "dim")
    print_ending(console, (), _hint(document))


def _rows(document: dict[str, Any], candidate: dict[str, Any]) -> list[dict[str, str]]:
    interval = f"{100.0 * document['confidence']:g} % interval"
    rows = []
    for check in candidate["checks"]:
        margins = zip(_MARGINS, shown_margins(document["quantiles"], check), strict=True)
        worst = check["worst_run"]
        rows.append(
            {"check": check["id"], "level": check["level"], **_counted(check, interval)}
            | {name: number(margin) for name, margin in margins}
            | {"worst run": "–" if worst is None else str(worst)}
        )
        rows += _point_rows(check, interval)
    everything = {"check": "any", "level": "required", **_counted(candidate["not_passed"], interval)}
    return [*rows, everything | _BLANK, *_point_rows(candidate["not_passed"], interval)]


def _point_rows(stated: Mapping[str, Any], interval: str) -> list[dict[str, str]]:
    return [
        {"check": f"  {words}", "level": "", **_counted(point, interval)} | _BLANK
        for words, point in listed_points(stated)
    ]


def listed_points(stated: Mapping[str, Any]) -> list[tuple[str, Mapping[str, Any]]]:
    """Return the points of a campaign that have rows of their own, each with its case and values in words.

    There are none where one row says the same of all: where nothing happened at any of them, in equally many runs.
    """
    points = stated.get("points", ())
    if len({(point["violations"], point["runs"]) for point in points}) < 2 and not stated["violations"]:
        return []
    several = len({point["case"] for point in points}) > 1
    return [(_point_in_words(point, with_case=several), point) for point in points]


def _point_in_words(point: Mapping[str, Any], *, with_case: bool) -> str:
    values = [f"{key} {value:g}" for key, value in point["parameters"].items()]
    return ", ".join([point["case"], *values] if with_case else values)


def _counted(stated: Mapping[str, Any], interval: str) -> dict[str, str]:
    return {
        "violated": share_text(stated),
        "probability": probability_text(stated.get("probability")),
        interval: interval_text(stated),
    }


def _fitting(console: Console, title: str, rows: Sequence[dict[str, str]]) -> Table:
    """Make the table, without columns that would have the others broken within words."""
    columns, unbounded = list(rows[0]), console.options.update(width=_UNBOUNDED)
    for spared in (*_SPARED, None):
        listed = table(*columns, right=tuple(name for name in columns if name not in _WORDS), title=title)
        for row in rows:
            listed.add_row(*(plain(row[name]) for name in columns))
        if spared is None or console.measure(listed, options=unbounded).maximum <= console.width:
            break
        columns.remove(spared)
    return listed


def _hint(document: dict[str, Any]) -> str:
    for specification, candidate in zip(document["specifications"], document["candidates"], strict=True):
        for check in candidate["checks"]:
            if check["counterexample"]:
                file = f"{document['output']}/{check['counterexample']}"
                return f"drivegate replay {quote(file)} --candidate {quote(specification)}"
    return ""


def probability_text(value: float | None) -> str:
    """Write a probability with three digits and never in powers of ten."""
    return "–" if value is None else np.format_float_positional(significant(value, 3), trim="-")


def interval_text(stated: Mapping[str, Any]) -> str:
    """Write the interval of a probability, or of each point where all have the same; a dash where there is none."""
    if not stated["runs"]:
        return "–"
    if stated["interval"] is None:
        return "–" if listed_points(stated) else f"{interval_text(stated['points'][0])} at each point"
    low, high = stated["interval"]
    return f"{probability_text(low)} to {probability_text(high)}"


def share_text(stated: Mapping[str, Any]) -> str:
    return f"{stated['violations']} of {stated['runs']}" if stated["runs"] else "–"


def shown_margins(
    shares: Sequence[float], check: Mapping[str, Any]
) -> tuple[float | None, float | None, float | None]:
    """Return a check's least margin, that of 5 % of the runs and the median; None where no run had any."""
    at = dict(zip(shares, check["margin_quantiles"], strict=False))
    return at.get(0.0), at.get(0.05), at.get(0.5)
