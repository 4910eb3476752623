"""A finished campaign on the console."""

from __future__ import annotations

from shlex import quote
from typing import TYPE_CHECKING, Any

from drivegate.output.console import number, plain, table

if TYPE_CHECKING:
    from rich.console import Console


def show_campaign(console: Console, document: dict[str, Any]) -> None:
    """Print a table for each candidate, and its first faults."""
    percent = f"{100.0 * document['confidence']:g} %"
    for candidate in document["candidates"]:
        verdicts = ", ".join(f"{count} {verdict}" for verdict, count in candidate["verdicts"].items())
        heading = f"{candidate['name']}: {verdicts}"
        columns = (
            "runs",
            "violations",
            "probability",
            f"{percent} interval",
            "worst margin",
            "5 %",
            "median",
        )
        listed = table("check", "level", *columns, "worst run", right=(*columns, "worst run"), title=heading)
        for check in candidate["checks"]:
            # The least, the 5 % quantile and the median.
            margins = dict(zip(document["quantiles"], check["margin_quantiles"], strict=False))
            listed.add_row(
                check["id"],
                check["level"],
                *_counted(check),
                *(number(margins.get(share)) for share in (0.0, 0.05, 0.5)),
                "–" if check["worst_run"] is None else str(check["worst_run"]),
            )
        listed.add_row("any required", "", *_counted(candidate["not_passed"]), "", "", "", "")
        console.print(listed)
        for fault in candidate["first_faults"]:
            console.print(
                plain(f"{fault['verdict']}: first in run {fault['run']}, {fault['file']}", "bold red")
            )
    console.print(plain(f"results: {document['output']}"))
    hint = _hint(document)
    if hint:
        console.print(plain(f"next: {hint}", "dim"))


def _counted(stated: dict[str, Any]) -> tuple[str, str, str, str]:
    if not stated["runs"]:
        return "0", "–", "–", "–"
    low, high = stated["interval"]
    return (
        str(stated["runs"]),
        str(stated["violations"]),
        f"{stated['probability']:.4g}",
        f"{low:.3g} to {high:.3g}",
    )


def _hint(document: dict[str, Any]) -> str:
    for specification, candidate in zip(document["specifications"], document["candidates"], strict=True):
        for check in candidate["checks"]:
            if check["counterexample"]:
                file = f"{document['output']}/{check['counterexample']}"
                return f"drivegate replay {quote(file)} --candidate {quote(specification)}"
    return ""
