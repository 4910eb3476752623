"""The tables of the comparison page that decide: ranking, who wins where, and how sure differences are."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from drivegate.contracts.current.checks.feasible_angles import FEASIBLE
from drivegate_reports.comparison.cells import Cell, Sheet, figure, name, written
from drivegate_reports.page.printable import clean

Row = Mapping[str, Any]


def ranking_sheet(document: Row) -> Sheet:
    """Show the ranking."""
    rows = []
    first = name(document["tables"]["ranking"][0]["candidate"])
    for row in document["tables"]["ranking"]:
        failed, held, all_points = row["required_failed"], row["points_held"], row["points_feasible"]
        compared = row["rank"] is not None
        rows.append(
            (
                Cell(name(row["candidate"])),
                Cell(str(row["rank"]), is_number=True) if compared else Cell(clean(row["status"]), "fail"),
                Cell("–" if failed is None else str(failed), "fail" if failed else "", is_number=True),
                Cell(f"{held} of {all_points}", "fail" if held < all_points else "", is_number=True),
                figure(row["input_power_w"], 1),
                figure(row["power_above_first_w"], 1, signed=True),
                figure(row["current_sum_a"], 2),
                figure(row["current_above_first_a"], 2, signed=True),
                Cell(str(row["points_shared"]), is_number=True),
                figure(row["gap_power_w"], 1, signed=True),
                figure(row["gap_current_percent"], 1, signed=True),
                figure(row["ripple_worst_percent"], 1),
                figure(row["converged_after_s"], 2),
            )
        )
    heads = (
        "candidate",
        "place",
        "required checks failed",
        "operating points held",
        "input power (W)",
        f"above {first} (W)",
        "Σ|i| (A)",
        f"above {first} (A)",
        "over points",
        "power above best possible (W)",
        "Σ|i| above best possible (%)",
        "worst ripple (%)",
        "converged after (s)",
    )
    caption = (
        f"Input power, Σ|i| and what they are above {first} are means over the points that both hold; the columns "
        "after them are about the points that the candidate holds itself, among those with a feasible angle. "
        f"{FEASIBLE}"
    )
    return Sheet("ranking", caption, heads, tuple(rows))


def region_sheet(document: Row) -> Sheet:
    """Show who wins where."""
    regions = document["tables"]["regions"]
    labels = list(dict.fromkeys(row["candidate"] for row in regions))
    by_region: dict[str, dict[str, Row]] = {}
    for row in regions:
        by_region.setdefault(row["region"], {})[row["candidate"]] = row
    rows = []
    for region, of in by_region.items():
        rows.append(
            (Cell(region), Cell(_winner(of)), *(_region_cell(of[label]) for label in labels if label in of))
        )
    caption = (
        "Each cell: watts of input power and amperes of Σ|i| above the least of the region, mean over its operating "
        "points. Only who holds all points of a region can win it; less than 0.1 % apart is no real difference."
    )
    return Sheet("regions", caption, ("where", "least input power", *map(name, labels)), tuple(rows))


def _winner(of: Mapping[str, Row]) -> str:
    known = {label: row for label, row in of.items() if row["input_power_w"] is not None}
    if not known:
        return "nobody holds all points"
    least = min(row["input_power_w"] for row in known.values())
    best = [name(label) for label, row in known.items() if row["power_above_best_w"] <= 1e-3 * least]
    if len(best) == 1:
        others = [
            row["power_above_best_w"]
            for label, row in known.items()
            if row["power_above_best_w"] > 1e-3 * least
        ]
        return (
            f"{best[0]}, by {written(min(others), 1)} W" if others else f"{best[0]}, the only one to hold it"
        )
    if len(best) == len(known) == len(of):
        return "no real difference"
    return " and ".join(best) if len(best) == 2 else ", ".join(best)


def _region_cell(row: Row) -> Cell:
    if row["input_power_w"] is None:
        lost = row["points"] - row["points_held"]
        return Cell(f"loses {lost} of {row['points']}", "fail", sort="1e9")
    watts, amperes = row["power_above_best_w"], row["current_above_best_a"]
    best = watts <= 1e-3 * row["input_power_w"]
    # Numbers keep together with their units.
    text = f"{written(watts, 1, signed=True)}\N{NO-BREAK SPACE}W, {written(amperes, 1, signed=True)}\N{NO-BREAK SPACE}A"
    return Cell(text, "pass" if best else "", sort=f"{watts:.6f}")


def difference_sheet(document: Row) -> Sheet:
    """Show every pair of candidates with the uncertainty of its difference."""
    words = {
        "input_power_w": "input power",
        "current_sum_a": "Σ|i|",
        "energy_wh_per_km": "energy",
        "current_sum_mean_a": "Σ|i|, mean of the cycle",
    }
    rows = []
    for row in document["tables"]["differences"]:
        real = row["verdict"] not in ("no real difference", "too few pairs")
        known = row["low"] is not None
        interval = (
            f"{written(row['low'], 2, signed=True)} to {written(row['high'], 2, signed=True)}"
            if known
            else "–"
        )
        rows.append(
            (
                Cell(clean(row["where"])),
                Cell(f"{words.get(row['quantity'], row['quantity'])} ({row['unit']})"),
                Cell(f"{name(row['first'])} − {name(row['second'])}"),
                figure(row["mean_difference"], 2, signed=True),
                Cell(interval, is_number=True),
                figure(row["relative_percent"], 2, signed=True),
                Cell(
                    f"{row['pairs']}" + (f" (+ {row['left_out']} lost)" if row["left_out"] else ""),
                    is_number=True,
                ),
                Cell(clean(row["verdict"]), "pass" if real else ""),
            )
        )
    heads = (
        "where",
        "quantity",
        "difference of",
        "mean",
        "interval",
        "of the second (%)",
        "pairs",
        "verdict",
    )
    return Sheet(
        "differences", "Every two candidates, run by run on the same scenarios and noise.", heads, tuple(rows)
    )
