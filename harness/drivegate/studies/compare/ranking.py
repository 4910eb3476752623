"""Who wins, by one simple rule, who wins where, and whether two candidates really differ."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, TypeAlias

from drivegate.contracts.comparison import POINTS, Excess, Population, Ranking, Row, mean_of
from drivegate.studies.compare.engine import COMPARED, FAULTED, REFUSED, Compared

CONFIDENCE: Final = 0.95
"""Confidence that all intervals of one quantity hold at once (1)."""
LEAST_EFFECT: Final = 0.001
"""Difference that matters, over the mean of both candidates (1)."""
FEWEST_PAIRS: Final = 3
"""Pairs below which no interval is reported."""
NO_DIFFERENCE: Final = "no real difference"
METHOD: Final = (
    "Differences are paired: both candidates ran the same scenario with the same noise, and only pairs in which both "
    "held the speed count. The interval is Student's t interval of the mean difference (scipy.special.stdtrit), "
    "widened after Bonferroni so that all pairs of candidates of one quantity hold together with 95 % confidence. A "
    "difference is called real where its interval does not hold zero and its mean exceeds 0.1 % of the quantity."
)
"""The method in words."""
Place: TypeAlias = tuple[float, float]
"""Speed (rpm) and load of an operating point."""
Held: TypeAlias = Mapping[str, Mapping[Place, Row]]
"""For each candidate, the operating points that it holds."""

_ORDER: Final = {COMPARED: 0, FAULTED: 1, REFUSED: 2}
_HEAVY_PERCENT: Final = 50.0


@dataclass(frozen=True)
class PairedDifference:
    """How the second candidate differs from the first."""

    pairs: int
    """Number of pairs."""
    mean: float | None
    """Mean of first less second; None without pairs."""
    low: float | None
    high: float | None
    """Interval of the mean; None with too few pairs."""
    relative_percent: float | None
    """Mean difference over the second's mean (%)."""
    verdict: str
    """``first lower``, ``first higher``, ``no real difference`` or ``too few pairs``."""


def paired_difference(
    first: Sequence[float], second: Sequence[float], *, intervals: int = 1
) -> PairedDifference:
    """Compare paired values."""
    changes = [a - b for a, b in zip(first, second, strict=True)]
    pairs = len(changes)
    if not pairs:
        return PairedDifference(0, None, None, None, None, "too few pairs")
    mean = math.fsum(changes) / pairs
    level = math.fsum([*map(abs, first), *map(abs, second)]) / (2 * pairs)
    base = math.fsum(second) / pairs
    relative = 100.0 * mean / base if base else None
    if pairs < FEWEST_PAIRS:
        return PairedDifference(pairs, mean, None, None, relative, "too few pairs")
    half = _half_width(changes, mean, intervals)
    low, high = mean - half, mean + half
    real = (low > 0.0 or high < 0.0) and abs(mean) > LEAST_EFFECT * level
    verdict = NO_DIFFERENCE if not real else ("first lower" if mean < 0.0 else "first higher")
    return PairedDifference(pairs, mean, low, high, relative, verdict)


def _half_width(changes: Sequence[float], mean: float, intervals: int) -> float:
    # The quantile by itself: scipy.stats takes a second to import.
    from scipy.special import stdtrit

    pairs = len(changes)
    variance = math.fsum((change - mean) ** 2 for change in changes) / (pairs - 1)
    quantile = float(stdtrit(pairs - 1, 1.0 - 0.5 * (1.0 - CONFIDENCE) / intervals))
    return quantile * math.sqrt(variance / pairs)


def difference_rows(
    labels: Sequence[str], populations: Sequence[Population], tables: Mapping[str, Sequence[Row]]
) -> list[Row]:
    """Compare every two candidates over the repeated runs."""
    pairs = [(first, second) for place, first in enumerate(labels) for second in labels[place + 1 :]]
    rows = []
    for where, runs, population in _all_runs(populations, tables):
        for figure in population.figures:
            for first, second in pairs:
                values = _paired(runs, first, second, figure.name, population.counts)
                made = paired_difference(*values[:2], intervals=len(pairs))
                rows.append(
                    {
                        "where": where,
                        "quantity": figure.name,
                        "unit": figure.unit,
                        "first": first,
                        "second": second,
                        "pairs": made.pairs,
                        "left_out": values[2],
                        "mean_difference": made.mean,
                        "low": made.low,
                        "high": made.high,
                        "relative_percent": made.relative_percent,
                        "verdict": _in_words(made.verdict, first, second),
                    }
                )
    return rows


def _all_runs(
    populations: Sequence[Population], tables: Mapping[str, Sequence[Row]]
) -> Iterator[tuple[str, list[Row], Population]]:
    """Go through the populations: where, its runs, and what it is."""
    for population in populations:
        runs = [row for row in tables[population.table] if population.contains(row)]
        if population.where:
            yield population.where, runs, population
            continue
        for scenario in dict.fromkeys(row["scenario"] for row in runs):
            yield scenario, [row for row in runs if row["scenario"] == scenario], population


def _paired(
    runs: Sequence[Row], first: str, second: str, key: str, counts: str
) -> tuple[list[float], list[float], int]:
    """Pair the runs by seed; one that either candidate lost is left out and counted."""
    by_seed = {
        label: {row["seed"]: row for row in runs if row["candidate"] == label} for label in (first, second)
    }
    seeds = sorted(set(by_seed[first]) & set(by_seed[second]))
    good = [
        seed
        for seed in seeds
        if all(by_seed[label][seed][counts] and by_seed[label][seed][key] is not None for label in by_seed)
    ]
    values = [[float(by_seed[label][seed][key]) for seed in good] for label in (first, second)]
    return values[0], values[1], len(seeds) - len(good)


def _in_words(verdict: str, first: str, second: str) -> str:
    return {
        "first lower": f"{first} is lower",
        "first higher": f"{second} is lower",
        NO_DIFFERENCE: NO_DIFFERENCE,
    }.get(verdict, verdict)


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
