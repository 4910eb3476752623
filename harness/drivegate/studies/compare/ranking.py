"""Who wins, by one simple rule, who wins where, and whether two candidates really differ."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import combinations, groupby
from typing import Any, Final

import pandas as pd

from drivegate.contracts.comparison import POINTS, Figure, Population, Ranking, Row, mean_of
from drivegate.contracts.drawings import column_of
from drivegate.studies.compare.engine import COMPARED, FAULTED, REFUSED, Compared

CONFIDENCE: Final = 0.95
"""Confidence that all intervals of one quantity hold at once (1)."""
LEAST_EFFECT: Final = 0.001
"""Difference that matters, over the mean of both candidates (1)."""
FEWEST_PAIRS: Final = 3
"""Pairs below which no interval is reported."""
NO_DIFFERENCE: Final = "no real difference"
TOO_FEW: Final = "too few pairs"
"""Verdicts on what is not known to differ."""
METHOD: Final = (
    "Differences are paired: both candidates ran the same scenario with the same noise, and only pairs in which both "
    "held the speed count. The interval is Student's t interval of the mean difference (scipy.special.stdtrit), "
    "widened after Bonferroni so that all pairs of candidates of one quantity hold together with 95 % confidence. A "
    "difference is called real where its interval does not hold zero and its mean exceeds 0.1 % of the quantity."
)
"""The method in words."""

_ORDER: Final = {COMPARED: 0, FAULTED: 1, REFUSED: 2}
_HEAVY_PERCENT: Final = 50.0
_LOADS: Final = {False: "below half load", True: "half load and more"}


def paired_difference(first: Sequence[float], second: Sequence[float], *, intervals: int = 1) -> Row:
    """Compare paired values: the mean of first less second with its interval, None where it is not known."""
    changes = [a - b for a, b in zip(first, second, strict=True)]
    pairs = len(changes)
    made: Row = {"pairs": pairs, **dict.fromkeys(("mean_difference", "low", "high", "relative_percent"))}
    if not pairs:
        return made | {"verdict": TOO_FEW}
    mean = math.fsum(changes) / pairs
    level = math.fsum([*map(abs, first), *map(abs, second)]) / (2 * pairs)
    base = math.fsum(second) / pairs
    made |= {"mean_difference": mean, "relative_percent": 100.0 * mean / base if base else None}
    if pairs < FEWEST_PAIRS:
        return made | {"verdict": TOO_FEW}
    half = _half_width(changes, mean, intervals)
    low, high = mean - half, mean + half
    real = (low > 0.0 or high < 0.0) and abs(mean) > LEAST_EFFECT * level
    verdict = NO_DIFFERENCE if not real else ("first lower" if mean < 0.0 else "first higher")
    return made | {"low": low, "high": high, "verdict": verdict}


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
    """Compare every two candidates over the repeated runs, paired by seed."""
    pairs = list(combinations(labels, 2))
    rows = []
    for where, runs, population in _all_runs(populations, tables):
        for figure in population.figures:
            counted = runs.assign(value=runs[figure.name].where(runs[population.counts].astype(bool)))
            # Two points of a narrow range of speeds may be one, so that a run is there twice.
            values = counted.pivot_table("value", "seed", "candidate", aggfunc="last", dropna=False)
            for first, second in pairs:
                both = values.reindex(columns=[first, second])
                known = both.dropna()
                made = paired_difference(*known.T.to_numpy(float).tolist(), intervals=len(pairs))
                verdict = {"first lower": f"{first} is lower", "first higher": f"{second} is lower"}
                rows.append(
                    {
                        "where": where,
                        "quantity": figure.name,
                        "unit": figure.unit,
                        "first": first,
                        "second": second,
                        "pairs": len(known),
                        "left_out": len(both) - len(known),
                        **made,
                        "verdict": verdict.get(made["verdict"], made["verdict"]),
                    }
                )
    return rows


def _all_runs(
    populations: Sequence[Population], tables: Mapping[str, Sequence[Row]]
) -> Iterator[tuple[str, pd.DataFrame, Population]]:
    """Go through the populations: where, its runs, and what it is."""
    for population in populations:
        names = [figure.name for figure in population.figures]
        table = frame_of(
            tables[population.table], "candidate", "group", "scenario", "seed", population.counts, *names
        )
        runs = table[population.contains(table)]
        if population.where:
            yield population.where, runs, population
            continue
        for scenario, own in runs.groupby("scenario", sort=False):
            yield str(scenario), own, population


def frame_of(rows: Sequence[Row], *columns: str) -> pd.DataFrame:
    """Return rows as a frame that has some columns even where there are no rows."""
    frame = pd.DataFrame(rows)
    return frame.reindex(columns=list(dict.fromkeys((*frame.columns, *columns))))


def rows_of(frame: pd.DataFrame) -> list[Row]:
    """Return a frame as rows of plain data, with None for what is not known."""
    rows: list[Any] = frame.astype(object).where(frame.notna(), None).to_dict("records")
    return rows


def rule_of(ranking: Ranking, *, checks: bool) -> str:
    """Return the rule in words."""
    rule = f"fewest required checks failed, then {ranking.rule}" if checks else ranking.rule
    return rule[0].upper() + rule[1:]


def ranking_rows(
    all_compared: Sequence[Compared], ranking: Ranking, tables: Mapping[str, Sequence[Row]]
) -> list[Row]:
    """Rank the candidates."""
    decisive = (ranking.decides, *(figure.name for figure in ranking.costs))
    points = frame_of(tables[POINTS], "candidate", "held", *ranking.place, *decisive)
    could = points[points["feasible"]] if "feasible" in points else points
    held = could[could["held"].astype(bool)]
    standings = sorted(_standings(all_compared, ranking, could, held, tables), key=_merit)
    rows: list[Row] = []
    for _, equals in groupby(standings, key=_merit):
        rows += _placed(list(equals), ranking, held, len(rows))
    for row in rows if ranking.costs else ():
        row.update(_against(row["candidate"], rows[0]["candidate"], ranking, held))
    return rows_of(pd.DataFrame(rows, dtype=object))


def _standings(
    all_compared: Sequence[Compared],
    ranking: Ranking,
    could: pd.DataFrame,
    held: pd.DataFrame,
    tables: Mapping[str, Sequence[Row]],
) -> Iterator[Row]:
    """Begin the row of each candidate: who it is, what has become of it, what it fails and holds, and its figures."""
    labels = [compared.label for compared in all_compared]
    counted = {"points_held": held, ranking.count: could}
    found = pd.DataFrame({key: frame.groupby("candidate").size() for key, frame in counted.items()})
    found = found.reindex(labels).fillna(0).astype(int)
    for table, summaries in ranking.summaries.items():
        frame = held if table == POINTS else frame_of(tables[table], "candidate")
        for key, (values, how) in summaries.items():
            found[key] = math.nan
            if len(frame):
                found[key] = column_of(frame, values).groupby(frame["candidate"]).agg(how)
    for compared, figures in zip(all_compared, rows_of(found), strict=True):
        failed = compared.failed_checks
        yield {
            "rank": None,
            "candidate": compared.label,
            "status": compared.status,
            "required_failed": None if failed is None else len(failed),
            "failed_checks": "" if failed is None else " ".join(failed),
            **figures,
        }


def _merit(row: Row) -> tuple[int, int, int]:
    return _ORDER[row["status"]], row["required_failed"] or 0, -row["points_held"]


def held_by_all(points: pd.DataFrame, key: str, labels: Iterable[str], place: Sequence[str]) -> pd.DataFrame:
    """Return the points that all of some candidates, or of some drives, hold."""
    names = set(labels)
    held = points[points["held"].astype(bool) & points[key].isin(names)]
    return held[held.groupby([*place])[key].transform("nunique") == len(names)]


def _placed(equals: list[Row], ranking: Ranking, held: pd.DataFrame, before: int) -> list[Row]:
    """Order candidates of equal merit, and assign places to those that can be compared."""
    shared = held_by_all(held, "candidate", (row["candidate"] for row in equals), ranking.place)
    means = shared.groupby("candidate")[ranking.decides].agg(mean_of).dropna().to_dict()
    for row in equals if ranking.at_shared else ():
        row[ranking.at_shared] = means.get(row["candidate"])
    equals.sort(key=lambda row: means.get(row["candidate"], 0.0))
    first = means.get(equals[0]["candidate"], 0.0)
    shared_place = before + 1
    for place, row in enumerate(equals):
        own = means.get(row["candidate"], 0.0)
        if own - first > ranking.same_share * first + ranking.same_amount:
            # The next place is shared with the first one there, as the best place is.
            first, shared_place = own, before + place + 1
        if row["status"] == COMPARED:
            row["rank"] = shared_place
    return equals


def _against(label: str, first: str, ranking: Ranking, held: pd.DataFrame) -> Row:
    """Compare a candidate with the first over the points that both hold."""
    shared = held_by_all(held, "candidate", (label, first), ranking.place)
    names = [figure.name for figure in ranking.costs]
    means = shared.groupby("candidate")[names].agg(mean_of).reindex([*{label, first}])
    own, other = (means.loc[who].to_dict() for who in (label, first))
    return {
        "points_shared": int((shared["candidate"] == label).sum()),
        **{name: own[name] for name in names},
        **{made.above.format("first"): own[made.name] - other[made.name] for made in ranking.costs},
    }


def region_rows(
    labels: Sequence[str], points: Sequence[Row], ends_rpm: Sequence[float], costs: Sequence[Figure]
) -> list[Row]:
    """List who wins where: in bands of the drive's speeds, at light and at heavy load."""
    names = [figure.name for figure in costs]
    table = frame_of(points, "candidate", "feasible", "speed_rpm", "load_percent", "held", *names)
    here = table[table["feasible"].astype(bool) & table["candidate"].isin(labels)]
    ends = sorted(set(ends_rpm))
    band = pd.cut(here["speed_rpm"].astype(float), ends, labels=False)
    heavy = here["load_percent"] >= _HEAVY_PERCENT
    of = here.groupby(
        [band, heavy, here["candidate"].astype(pd.CategoricalDtype(list(labels)))], observed=True
    )
    found = of.agg(points=("held", "size"), points_held=("held", "sum"))
    # Only who holds all points of a region can win it.
    found[names] = of[names].agg(mean_of).where(found["points"] == found["points_held"])
    least = found.groupby(level=[0, 1], observed=True)[names].transform("min")
    for figure in costs:
        found[figure.above.format("best")] = found[figure.name] - least[figure.name]
    found.insert(0, "candidate", found.index.get_level_values(2))
    where = [f"{_band(*ends[number : number + 2])}, {_LOADS[heavy]}" for number, heavy, _ in found.index]
    found.insert(0, "region", where)
    return rows_of(found)


def _band(low: float, high: float) -> str:
    if high == math.inf:
        return f"above {low:g} rpm"
    return f"up to {high:g} rpm" if low == 0.0 else f"{low:g} to {high:g} rpm"
