"""Every two candidates of a comparison over repeated runs, with uncertainty."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from drivegate.contracts.comparison import Population, Row
from drivegate.studies.compare.statistics import NO_DIFFERENCE, paired_difference


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
