"""Which controller of duty ratios is first, by one simple rule."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, Final

from drivegate.studies.compare.engine import Compared
from drivegate.studies.compare.ranking import COMPARED, equals_of, standing_of
from drivegate.studies.compare.statistics import mean_of

Row = dict[str, Any]

RULE: Final = (
    "Fewest required checks failed, then most operating points held, then least mean loss above the least possible "
    "over the points that all equals hold; means within 0.1 % share a place."
)
"""The rule in words."""
RULE_WITHOUT_CHECKS: Final = (
    "Most operating points held, then least mean loss above the least possible over the points that all equals hold; "
    "means within 0.1 % share a place."
)
"""The same where no checks were made."""
_SAME_PERCENT: Final = 0.1
_Place = tuple[float, float]


def duty_ranking(all_compared: Sequence[Compared], points: Sequence[Row], steps: Sequence[Row]) -> list[Row]:
    """Rank the candidates."""
    held = {
        compared.label: {
            (row["speed_rpm"], row["reference_nm"]): row
            for row in points
            if row["candidate"] == compared.label and row["held"]
        }
        for compared in all_compared
    }
    standings = [_standing(compared, held[compared.label], points, steps) for compared in all_compared]
    ranked: list[Row] = []
    for equals in equals_of(standings):
        ranked += _placed(equals, held, len(ranked))
    return ranked


def _placed(equals: list[Row], held: dict[str, dict[_Place, Row]], before: int) -> list[Row]:
    """Order candidates of equal merit by their losses, and give places to those that can be compared."""
    common = set.intersection(*(set(held[row["candidate"]]) for row in equals))
    for row in equals:
        own = held[row["candidate"]]
        row["loss_at_shared_percent"] = _mean(
            "loss_above_least_percent", (own[place] for place in sorted(common))
        )
    equals.sort(key=lambda row: row["loss_at_shared_percent"] or 0.0)
    best = equals[0]["loss_at_shared_percent"] or 0.0
    for place, row in enumerate(equals):
        if row["status"] == COMPARED:
            shares = (row["loss_at_shared_percent"] or 0.0) - best <= _SAME_PERCENT
            row["rank"] = before + 1 if shares else before + place + 1
    return equals


def _standing(
    compared: Compared, held: dict[_Place, Row], points: Sequence[Row], steps: Sequence[Row]
) -> Row:
    own_steps = [row for row in steps if row["candidate"] == compared.label]
    rises = [
        None if row["rise_ms"] is None else 100.0 * row["rise_ms"] / row["allowed_ms"] for row in own_steps
    ]
    known = [rise for rise in rises if rise is not None]
    return {
        **standing_of(compared),
        "points_held": len(held),
        "points": sum(row["candidate"] == compared.label for row in points),
        "loss_above_least_percent": _mean("loss_above_least_percent", held.values()),
        "loss_worst_percent": _worst("loss_above_least_percent", held.values()),
        "current_above_least_percent": _mean("current_above_least_percent", held.values()),
        "ripple_worst_percent": _worst("ripple_percent", held.values()),
        "overshoot_worst_percent": _worst("overshoot_percent", own_steps),
        "rise_worst_percent_of_allowed": max(known) if known and len(known) == len(rises) else None,
    }


def _mean(key: str, rows: Iterable[Row]) -> float | None:
    return mean_of(row[key] for row in rows if row[key] is not None)


def _worst(key: str, rows: Iterable[Row]) -> float | None:
    return max((row[key] for row in rows if row[key] is not None), default=None)
