"""Every two candidates of a comparison over drawn plants, noise and the drive cycle, with uncertainty."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, Final

from drivegate.studies.compare.statistics import NO_DIFFERENCE, paired_difference

Row = dict[str, Any]


def difference_rows(labels: Sequence[str], repeated: Sequence[Row], cycles: Sequence[Row]) -> list[Row]:
    """Compare every two candidates over drawn plants, noise and the drive cycle."""
    pairs = [(first, second) for place, first in enumerate(labels) for second in labels[place + 1 :]]
    rows = []
    for where, runs, keys, counts in _populations(repeated, cycles):
        for key, unit in keys:
            for first, second in pairs:
                values = _paired(runs, first, second, key, counts)
                made = paired_difference(*values[:2], intervals=len(pairs))
                rows.append(
                    {
                        "where": where,
                        "quantity": key,
                        "unit": unit,
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


_STEADY_KEYS: Final = (("input_power_w", "W"), ("current_sum_a", "A"))
_CYCLE_KEYS: Final = (("energy_wh_per_km", "Wh/km"), ("current_sum_mean_a", "A"))


def _populations(
    repeated: Sequence[Row], cycles: Sequence[Row]
) -> Iterable[tuple[str, list[Row], tuple[tuple[str, str], ...], str]]:
    yield "drawn plants and noise", [row for row in repeated if row["group"] == "drawn"], _STEADY_KEYS, "held"
    noise = [row for row in repeated if row["group"] == "noise"]
    for scenario in dict.fromkeys(row["scenario"] for row in noise):
        yield scenario, [row for row in noise if row["scenario"] == scenario], _STEADY_KEYS, "held"
    noisy = [row for row in cycles if row["seed"] is not None]
    yield "drive cycle, noisy sensors", noisy, _CYCLE_KEYS, "follows"


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
