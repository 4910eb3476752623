"""Who wins, by one simple rule, and who wins where."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Final, TypeAlias

from drivegate.contracts.comparison import POINTS, Excess, Ranking, Row, mean_of
from drivegate.studies.compare.engine import COMPARED, FAULTED, REFUSED, Compared

Place: TypeAlias = tuple[float, float]
"""Speed (rpm) and load of an operating point."""
Held: TypeAlias = Mapping[str, Mapping[Place, Row]]
"""For each candidate, the operating points that it holds."""

_ORDER: Final = {COMPARED: 0, FAULTED: 1, REFUSED: 2}
_HEAVY_PERCENT: Final = 50.0


def rule_of(ranking: Ranking, *, checks: bool) -> str:
    """Return the rule in words."""
    rule = f"fewest required checks failed, then {ranking.rule}" if checks else ranking.rule
    return rule[0].upper() + rule[1:]


def ranking_rows(
    all_compared: Sequence[Compared], ranking: Ranking, tables: Mapping[str, Sequence[Row]]
) -> list[Row]:
    """Rank the candidates."""
    held = {
        compared.label: {
            (row[ranking.place[0]], row[ranking.place[1]]): row
            for row in tables[POINTS]
            if row["candidate"] == compared.label and row["held"] and row.get("feasible", True)
        }
        for compared in all_compared
    }
    rows: list[Row] = []
    for equals in _equals(_standing(compared, ranking, held, tables) for compared in all_compared):
        rows += _placed(equals, ranking, held, len(rows))
    for row in rows if ranking.against_first else ():
        row.update(_against(row["candidate"], rows[0]["candidate"], ranking.against_first, held))
    return rows


def _standing(compared: Compared, ranking: Ranking, held: Held, tables: Mapping[str, Sequence[Row]]) -> Row:
    """Begin the row of a candidate: who it is, what has become of it, what it fails and holds."""
    label, failed = compared.label, compared.failed_checks
    own = {name: [row for row in rows if row["candidate"] == label] for name, rows in tables.items()}
    could = sum(row.get("feasible", True) for row in own[POINTS])
    own[POINTS] = list(held[label].values())
    return {
        "rank": None,
        "candidate": label,
        "status": compared.status,
        "required_failed": None if failed is None else len(failed),
        "failed_checks": "" if failed is None else " ".join(failed),
        "points_held": len(held[label]),
        ranking.count: could,
        **{summary.name: summary.value(own[summary.table]) for summary in ranking.summaries},
    }


def _equals(standings: Iterable[Row]) -> Iterator[list[Row]]:
    """Group candidates that fail and hold equally many, the best first."""
    by_merit: dict[tuple[int, int, int], list[Row]] = {}
    for row in standings:
        merit = (_ORDER[row["status"]], row["required_failed"] or 0, -row["points_held"])
        by_merit.setdefault(merit, []).append(row)
    for _, equals in sorted(by_merit.items()):
        yield equals


def _placed(equals: list[Row], ranking: Ranking, held: Held, before: int) -> list[Row]:
    """Order candidates of equal merit, and assign places to those that can be compared."""
    common = set.intersection(*(set(held[row["candidate"]]) for row in equals))
    means: dict[str, float] = {}
    for row in equals:
        points = (held[row["candidate"]][place][ranking.decides] for place in common)
        mean = mean_of(value for value in points if value is not None)
        means[row["candidate"]] = mean or 0.0
        if ranking.at_shared:
            row[ranking.at_shared] = mean
    equals.sort(key=lambda row: means[row["candidate"]])
    best = means[equals[0]["candidate"]]
    for place, row in enumerate(equals):
        if row["status"] == COMPARED:
            above = means[row["candidate"]] - best
            shares = above <= ranking.same_share * best + ranking.same_amount
            row["rank"] = before + 1 if shares else before + place + 1
    return equals


def _against(label: str, first: str, excesses: Sequence[Excess], held: Held) -> Row:
    """Compare a candidate with the first over the points that both hold."""
    both = sorted(set(held[label]) & set(held[first]))
    own, others = (
        {made.figure.name: mean_of(held[who][place][made.figure.name] for place in both) for made in excesses}
        for who in (label, first)
    )
    above = {made.above: _difference(own[made.figure.name], others[made.figure.name]) for made in excesses}
    return {"points_shared": len(both), **own, **above}


def _difference(own: float | None, other: float | None) -> float | None:
    return None if own is None or other is None else own - other


def region_rows(
    all_compared: Sequence[Compared],
    points: Sequence[Row],
    ends_rpm: Sequence[float],
    excesses: Sequence[Excess],
) -> list[Row]:
    """List who wins where: in bands of the drive's speeds, at light and at heavy load."""
    labels = [compared.label for compared in all_compared if compared.status == COMPARED]
    rows: list[Row] = []
    for name, inside in _regions(ends_rpm):
        here = [row for row in points if row["feasible"] and inside(row)]
        if here:
            rows += _region(
                name,
                {label: [row for row in here if row["candidate"] == label] for label in labels},
                excesses,
            )
    return rows


def _region(name: str, runs: dict[str, list[Row]], excesses: Sequence[Excess]) -> list[Row]:
    rows: list[Row] = []
    for label, own in runs.items():
        held = [row for row in own if row["held"]]
        whole = bool(own) and len(held) == len(own)
        means = {
            made.figure.name: mean_of(row[made.figure.name] for row in held) if whole else None
            for made in excesses
        }
        counts = {"points": len(own), "points_held": len(held)}
        rows.append({"region": name, "candidate": label, **counts, **means})
    for made in excesses:
        key = made.figure.name
        least = min((row[key] for row in rows if row[key] is not None), default=0.0)
        for row in rows:
            row[made.above] = _difference(row[key], least)
    return rows


def _regions(ends_rpm: Sequence[float]) -> Iterable[tuple[str, Callable[[Row], bool]]]:
    for low, high in pairwise(ends_rpm):
        speeds = f"up to {high:g} rpm" if low == 0.0 else f"{low:g} to {high:g} rpm"
        speeds = f"above {low:g} rpm" if high == math.inf else speeds
        for heavy in (False, True):
            load = "half load and more" if heavy else "below half load"
            yield f"{speeds}, {load}", _within(low, high, heavy)


def _within(low: float, high: float, heavy: bool) -> Callable[[Row], bool]:
    return lambda row: low < row["speed_rpm"] <= high and (row["load_percent"] >= _HEAVY_PERCENT) == heavy
