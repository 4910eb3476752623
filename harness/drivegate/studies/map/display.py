"""A finished operating map on the console."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from drivegate.output.console import number, plain, table

if TYPE_CHECKING:
    from rich.console import Console


def show_map(console: Console, document: dict[str, Any], title: str) -> None:
    """Print the ranges of a map and the files of it."""
    listed = table(
        "quantity",
        "lowest",
        "highest",
        right=("lowest", "highest"),
        title=f"{title}: {document['points']} points",
    )
    for name, span in document["ranges"].items():
        listed.add_row(name, number(span["lowest"]), number(span["highest"]))
    console.print(listed)
    if document["verdicts"]:
        console.print(
            plain(", ".join(f"{count} {verdict}" for verdict, count in document["verdicts"].items()))
        )
    elif document["without_values"]:
        console.print(plain(f"{document['without_values']} points are out of reach and have no values"))
    if document.get("not_certified"):
        console.print(
            plain(
                f"{document['not_certified']} points have no periodic state; their means are over many cycles"
            )
        )
    seconds = document["timing"]["seconds"]
    console.print(plain(f"{document['points'] / max(seconds, 1e-9):.3g} points a second", "dim"))
    for path in document["files"]:
        console.print(plain(f"written: {path}"))
    if not document["files"]:
        console.print(plain("next: the same with --plot map.png and --parquet map.parquet", "dim"))
