"""Who wins, by one simple rule, and who wins where."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import pairwise
from typing import Any, Final

from drivegate.scenarios.drive_scale import DriveScale
from drivegate.studies.compare.engine import Compared
from drivegate.studies.compare.statistics import LEAST_EFFECT, mean_of

Row = dict[str, Any]

RULE: Final = (
    "Fewest required checks failed, then most operating points held within k1, then least mean true input power "
    "over the points that all equals hold; means within 0.1 % share a place."
)
"""The rule in words."""
RULE_WITHOUT_CHECKS: Final = (
    "Most operating points held within k1, then least mean true input power over the points that all equals hold; "
    "means within 0.1 % share a place."
)
"""The same where no checks were made."""
COMPARED, FAULTED, REFUSED = "compared", "faulted", "refused"
"""What can become of a candidate."""

Place = tuple[float, float]
"""Speed (rpm) and load (%) of an operating point."""

_ORDER: Final = {COMPARED: 0, FAULTED: 1, REFUSED: 2}
_MEANS: Final = {"input_power_w": "power_above_best_w", "current_sum_a": "current_above_best_a"}
_BANDS_END_AT: Final = (0.3, 0.7, 1.0)
"""Ends of the bands of speed, shares of the range from base speed to the highest (1)."""
_HEAVY_PERCENT: Final = 50.0


def status_of(compared: Compared) -> str:
    """Tell what has become of a candidate."""
    if compared.error is not None or compared.candidate is None:
        return REFUSED
    return FAULTED if compared.faults else COMPARED


def _failed_checks(compared: Compared) -> list[str] | None:
    """List the required checks that a candidate fails; None where they were not made."""
    if compared.outcomes is None:
        return None
    return [
        outcome.id
        for outcome in compared.outcomes
        if outcome.level == "required" and outcome.verdict == "fail"
    ]


def standing_of(compared: Compared) -> Row:
    """Begin the row of a candidate: who it is, what has become of it, and what it fails."""
    failed = _failed_checks(compared)
    return {
        "rank": None,
        "candidate": compared.label,
        "status": status_of(compared),
        "required_failed": None if failed is None else len(failed),
        "failed_checks": "" if failed is None else " ".join(failed),
    }


def equals_of(standings: Iterable[Row]) -> Iterator[list[Row]]:
    """Group candidates that fail and hold equally many, the best first."""
    by_merit: dict[tuple[int, int, int], list[Row]] = {}
    for row in standings:
        merit = (_ORDER[row["status"]], row["required_failed"] or 0, -row["points_held"])
        by_merit.setdefault(merit, []).append(row)
    for _, equals in sorted(by_merit.items()):
        yield equals


def ranking_rows(all_compared: Sequence[Compared], points: Sequence[Row]) -> list[Row]:
    """Rank the candidates."""
    held = _held(all_compared, points)
    standings = [_standing(compared, points, held[compared.label]) for compared in all_compared]
    rows = _placed(standings, held)
    for row in rows:
        row.update(_against(row, rows[0], held))
    return rows


def _held(all_compared: Sequence[Compared], points: Sequence[Row]) -> dict[str, dict[Place, Row]]:
    """Sort the feasible operating points that were held by candidate and place."""
    return {
        compared.label: {
            _place(row): row
            for row in points
            if row["candidate"] == compared.label and row["held"] and row["feasible"]
        }
        for compared in all_compared
    }


def _placed(standings: list[Row], held: dict[str, dict[Place, Row]]) -> list[Row]:
    """Put the candidates in order, and give places to those that can be compared."""
    rows: list[Row] = []
    for equals in equals_of(standings):
        common = set.intersection(*(set(held[row["candidate"]]) for row in equals))
        watts = {
            row["candidate"]: mean_of(held[row["candidate"]][place]["input_power_w"] for place in common)
            for row in equals
        }
        equals.sort(key=lambda row: watts[row["candidate"]] or 0.0)
        best, first = watts[equals[0]["candidate"]] or 0.0, len(rows) + 1
        for row in equals:
            if row["status"] == COMPARED:
                above = (watts[row["candidate"]] or 0.0) - best
                row["rank"] = first if above <= LEAST_EFFECT * best else len(rows) + 1
            rows.append(row)
    return rows


def _standing(compared: Compared, points: Sequence[Row], held: dict[Place, Row]) -> Row:
    own = [row for row in points if row["candidate"] == compared.label]
    return {
        **standing_of(compared),
        "points_held": len(held),
        "points_feasible": sum(row["feasible"] for row in own),
        "gap_power_w": mean_of(_known(held.values(), "gap_power_w")),
        "gap_current_percent": mean_of(_known(held.values(), "gap_current_percent")),
        "ripple_worst_percent": max((row["ripple_percent"] for row in held.values()), default=None),
        "converged_after_s": mean_of(_known(held.values(), "converged_after_s")),
    }


def _against(row: Row, best: Row, held: dict[str, dict[Place, Row]]) -> Row:
    """Compare a candidate with the best over the points that both hold."""
    own, others = held[row["candidate"]], held[best["candidate"]]
    both = sorted(set(own) & set(others))
    watts, amperes = (
        mean_of(own[place][key] for place in both) for key in ("input_power_w", "current_sum_a")
    )
    best_watts, best_amperes = (
        mean_of(others[place][key] for place in both) for key in ("input_power_w", "current_sum_a")
    )
    return {
        "points_shared": len(both),
        "input_power_w": watts,
        "current_sum_a": amperes,
        "power_above_first_w": None if watts is None or best_watts is None else watts - best_watts,
        "current_above_first_a": None if amperes is None or best_amperes is None else amperes - best_amperes,
    }


def _place(row: Row) -> Place:
    return row["speed_rpm"], row["load_percent"]


def _known(rows: Iterable[Row], key: str) -> list[float]:
    return [row[key] for row in rows if row[key] is not None]


def region_rows(all_compared: Sequence[Compared], points: Sequence[Row], scale: DriveScale) -> list[Row]:
    """Tell who wins where: in bands of the drive's speeds, at light and at heavy load."""
    labels = [compared.label for compared in all_compared if status_of(compared) == COMPARED]
    rows: list[Row] = []
    for name, inside in _regions(scale):
        here = [row for row in points if row["feasible"] and inside(row)]
        if here:
            rows += _region(
                name, {label: [row for row in here if row["candidate"] == label] for label in labels}
            )
    return rows


def _region(name: str, runs: dict[str, list[Row]]) -> list[Row]:
    rows: list[Row] = []
    for label, own in runs.items():
        held = [row for row in own if row["held"]]
        whole = bool(own) and len(held) == len(own)
        means = {key: mean_of(row[key] for row in held) if whole else None for key in _MEANS}
        counts = {"points": len(own), "points_held": len(held)}
        rows.append({"region": name, "candidate": label, **counts, **means})
    for key, above in _MEANS.items():
        least = min(_known(rows, key), default=0.0)
        for row in rows:
            row[above] = None if row[key] is None else row[key] - least
    return rows


def _regions(scale: DriveScale) -> Iterable[tuple[str, Callable[[Row], bool]]]:
    ends = (0.0, *map(scale.speed, _BANDS_END_AT), math.inf)
    for low, high in pairwise(ends):
        speeds = f"up to {high:g} rpm" if low == 0.0 else f"{low:g} to {high:g} rpm"
        speeds = f"above {low:g} rpm" if high == math.inf else speeds
        for heavy in (False, True):
            load = "half load and more" if heavy else "below half load"
            yield f"{speeds}, {load}", _within(low, high, heavy)


def _within(low: float, high: float, heavy: bool) -> Callable[[Row], bool]:
    return lambda row: low < row["speed_rpm"] <= high and (row["load_percent"] >= _HEAVY_PERCENT) == heavy
