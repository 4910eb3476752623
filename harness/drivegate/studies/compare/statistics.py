"""Whether two candidates really differ: intervals of the mean of paired differences."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from drivegate.contracts.comparison import Population, Row

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
