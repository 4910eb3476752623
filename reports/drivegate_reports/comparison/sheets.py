"""The tables of the comparison page: ranking, who wins where, how sure that is, and what was measured in runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, Final, TypeAlias

from drivegate.contracts.catalogue import comparison_of
from drivegate.contracts.comparison import Column, Comparison, Figure, Words, name_of
from drivegate_reports.comparison.cells import Cell, Sheet, name, sheet_of, written
from drivegate_reports.page.page import clean

Row: TypeAlias = Mapping[str, Any]

_SAME: Final = 1e-3
"""Share of a mean below which a difference is no real one (1)."""
FAILED: Final = Words(
    "required checks failed",
    lambda row: "–" if row["required_failed"] is None else str(row["required_failed"]),
    lambda row: "fail" if row["required_failed"] else "",
)
"""How many required checks a candidate fails."""


def held_of(points: str) -> Words:
    """Return the column of how many operating points a candidate holds, of those under a key."""
    return Words(
        "operating points held",
        lambda row: f"{row['points_held']} of {row[points]}",
        lambda row: "fail" if row["points_held"] < row[points] else "",
    )


_PLACE: Final = Words(
    "place",
    lambda row: str(row["status"] if row["rank"] is None else row["rank"]),
    lambda row: "fail" if row["rank"] is None else "",
)


def table_sheet(document: Row, table: str) -> Sheet | None:
    """Show a table of a comparison; None where it has nothing to show."""
    comparison = comparison_of(document["kind"])
    if table in _DECIDING:
        return _DECIDING[table](document, comparison)
    found = next(made for made in comparison.tables if made.name == table)
    rows = found.shown(document["tables"][table])
    return sheet_of(table, clean(found.caption(document)), found.columns, rows)


def _ranking(document: Row, comparison: Comparison) -> Sheet:
    ranking, rows = comparison.ranking, document["tables"]["ranking"]
    first = name(rows[0]["candidate"])
    columns: tuple[Column, ...] = (
        name_of("candidate"),
        _PLACE,
        FAILED,
        held_of(ranking.count),
        *ranking.columns,
    )
    return sheet_of("ranking", clean(ranking.caption(first)), columns, rows, first)


def _regions(document: Row, comparison: Comparison) -> Sheet:
    costs = comparison.ranking.costs
    regions = document["tables"]["regions"]
    labels = list(dict.fromkeys(row["candidate"] for row in regions))
    by_region: dict[str, dict[str, Row]] = {}
    for row in regions:
        by_region.setdefault(row["region"], {})[row["candidate"]] = row
    rows = [
        (
            Cell(region),
            Cell(_winner(of, costs[0])),
            *(_region_cell(of[label], costs) for label in labels if label in of),
        )
        for region, of in by_region.items()
    ]
    quantities = " and ".join(f"{made.label} ({made.unit})" for made in costs)
    caption = (
        f"Each cell: {quantities} above the least of the region, mean over its operating points. Only who holds all "
        "points of a region can win it; less than 0.1 % apart is no real difference."
    )
    heads = ("where", f"least {costs[0].label}", *map(name, labels))
    return Sheet("regions", caption, heads, tuple(rows))


def _winner(of: Mapping[str, Row], figure: Figure) -> str:
    key, unit, digits = figure.name, figure.unit, figure.digits or 0
    above = figure.above.format("best")
    known = {label: row for label, row in of.items() if row[key] is not None}
    if not known:
        return "nobody holds all points"
    same = _SAME * min(row[key] for row in known.values())
    best = [name(label) for label, row in known.items() if row[above] <= same]
    others = [row[above] for row in known.values() if row[above] > same]
    if len(best) == 1:
        return (
            f"{best[0]}, by {written(min(others), digits)} {unit}"
            if others
            else f"{best[0]}, the only one to hold it"
        )
    if len(best) == len(known) == len(of):
        return "no real difference"
    return joined(best)


def joined(names: Sequence[str]) -> str:
    """Join names by commas and a last ``and``."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _region_cell(row: Row, costs: Sequence[Figure]) -> Cell:
    if row[costs[0].name] is None:
        lost = row["points"] - row["points_held"]
        return Cell(f"loses {lost} of {row['points']}", "fail", sort="1e9")
    above = row[costs[0].above.format("best")]
    # Numbers stay on one line with their units.
    text = ", ".join(
        f"{written(row[made.above.format('best')], 1, signed=True)}\N{NO-BREAK SPACE}{made.unit}"
        for made in costs
    )
    best = above <= _SAME * row[costs[0].name]
    return Cell(text, "pass" if best else "", sort=f"{above:.6f}")


def is_real(row: Row) -> bool:
    """Return True if a difference is more than chance and matters."""
    return row["verdict"] not in ("no real difference", "too few pairs")


def _interval(row: Row) -> str:
    if row["low"] is None:
        return "–"
    return f"{written(row['low'], 2, signed=True)} to {written(row['high'], 2, signed=True)}"


def _differences(document: Row, comparison: Comparison) -> Sheet:
    labels = {made.name: made.label for population in comparison.populations for made in population.figures}
    columns = (
        name_of("where"),
        Words("quantity", lambda row: f"{labels.get(row['quantity'], row['quantity'])} ({row['unit']})"),
        Words("difference of", lambda row: f"{name(row['first'])} − {name(row['second'])}"),
        Figure("mean_difference", "mean", signed=True),
        Words("interval", _interval),
        Figure("relative_percent", "of the second", "%", signed=True),
        Words(
            "pairs",
            lambda row: f"{row['pairs']}" + (f" (+ {row['left_out']} lost)" if row["left_out"] else ""),
        ),
        Words("verdict", lambda row: str(row["verdict"]), lambda row: "pass" if is_real(row) else ""),
    )
    caption = "Every two candidates, run by run on the same scenarios and noise."
    return sheet_of("differences", caption, columns, document["tables"]["differences"])


def _checks(document: Row, _comparison: Comparison) -> Sheet | None:
    """Show margin and verdict of every check side by side."""
    checks = document["tables"]["checks"]
    if not checks:
        return None
    labels = list(dict.fromkeys(row["candidate"] for row in checks))
    of = {(row["check"], row["candidate"]): row for row in checks}
    rows = []
    for check in dict.fromkeys(row["check"] for row in checks):
        row = next(row for row in checks if row["check"] == check)
        cells = (_check_cell(of.get((check, label))) for label in labels)
        rows.append((Cell(clean(check)), Cell(clean(row["level"])), *cells, Cell(clean(row["requirement"]))))
    caption = (
        f"Least margin over all runs at {document['checks_effort']} effort: distance from the limit over the limit, "
        "negative where the requirement is not met."
    )
    return Sheet("checks", caption, ("check", "level", *map(name, labels), "requirement"), tuple(rows))


def _check_cell(row: Row | None) -> Cell:
    if row is None:
        return Cell("–")
    if row["margin"] is None:
        return Cell(clean(row["verdict"]))
    failing = "fail" if row["level"] == "required" else "caution"
    tone = {"pass": "pass", "fail": failing}.get(row["verdict"], "")
    text = f"{row['verdict']} {written(row['margin'], 3, signed=True)}"
    return Cell(text, tone, sort=f"{row['margin']:.6f}")


def _timing(document: Row, _comparison: Comparison) -> Sheet | None:
    """Show time and size of a controller's step."""
    kinds = {entry["label"]: entry["kind"] for entry in document["candidates"]}
    columns = (
        name_of("candidate"),
        Words("kind", lambda row: str(kinds.get(row["candidate"]) or "–")),
        Figure("step_us", "time of a step", "µs", 3),
        Figure("share_of_period_percent", "of the control period", "%", 3),
        Figure("state_bytes", "state", "bytes", 0),
    )
    # Documents of earlier versions have no times of some contracts.
    rows = document["timing"].get("steps", ())
    caption = "Measured on the machine that compared; no part of the ranking or of the content hash."
    return sheet_of("timing", caption, columns, rows) if rows else None


_DECIDING: Final[Mapping[str, Callable[[Row, Comparison], Sheet | None]]] = MappingProxyType(
    {
        "ranking": _ranking,
        "regions": _regions,
        "differences": _differences,
        "checks": _checks,
        "timing": _timing,
    }
)
"""The tables that every contract may have, by name."""
