"""Joint changes: each pair of levels of any two factors in some run, as a covering array has them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from itertools import combinations
from typing import Final, TypeAlias

FACTORS: Final[Mapping[str, tuple[str, ...]]] = {
    "fault": (
        "none",
        "speed lost",
        "currents lost",
        "supply lost",
        "sample of a phase lost twenty times",
        "false edges",
        "unequal halves",
        "drift",
        "restart",
        "restarted twenty times",
    ),
    "load course": ("steady", "up", "down", "ramp", "vanishing", "repeated"),
    "speed course": ("steady", "up", "down", "standstill", "overspeed"),
    "plant": ("nominal", "resistance", "inductance", "EMF", "friction"),
    "control period": ("500 µs", "400 µs", "250 µs", "100 µs"),
    "supply": ("nominal", "dip", "sag", "swell"),
    "sensors": ("ideal", "real", "gain of a phase", "offset of a phase"),
    "load": ("torque", "power", "fan", "vehicle"),
    "clock": ("0", "2³¹ µs", "2³² µs"),
    "rotor": ("0°", "any"),
    "moment": ("settled", "searching"),
}
"""What is varied jointly, and the levels of each; the first one is what a plain run has."""

Row: TypeAlias = Mapping[str, str]
"""A level of each factor."""

IMPOSSIBLE: Final[Mapping[frozenset[tuple[str, str]], str]] = {
    frozenset(pair): reason
    for reason, pairs in {
        "ideal sensors and single wrong ones have no encoder": [
            (("fault", "false edges"), ("sensors", level))
            for level in ("ideal", "gain of a phase", "offset of a phase")
        ],
        "a vehicle has grades, no shares of a load": [
            (("load", "vehicle"), ("load course", level))
            for level in ("down", "ramp", "vanishing", "repeated")
        ],
        "a load of constant power, or a vehicle, needs a turning shaft": [
            (("speed course", "standstill"), ("load", level)) for level in ("power", "vehicle", "fan")
        ],
        "a shaft that is to come to a standstill must have its load": [
            (("speed course", "standstill"), ("load course", level)) for level in ("vanishing", "repeated")
        ],
        "a vehicle is too heavy for the shaft to slow down in time": [
            (("speed course", "down"), ("load", "vehicle"))
        ],
        "a shaft whose load vanishes does not slow down": [
            (("speed course", "down"), ("load course", "vanishing"))
        ],
    }.items()
    for pair in pairs
}
"""Pairs of levels that no scenario can have, each with the reason."""


def is_possible(levels: Sequence[str]) -> bool:
    """Return True if a row, or the first levels of one, has no impossible pair."""
    given = zip(FACTORS, levels, strict=False)
    return not any(frozenset(pair) in IMPOSSIBLE for pair in combinations(given, 2))


def possible_pairs() -> Iterator[frozenset[tuple[str, str]]]:
    for (one, ones), (other, others) in combinations(FACTORS.items(), 2):
        for level in ones:
            for opposite in others:
                pair = frozenset(((one, level), (other, opposite)))
                if pair not in IMPOSSIBLE:
                    yield pair


@cache
def covering_rows() -> tuple[Row, ...]:
    """List rows that together have every possible pair."""
    from allpairspy import AllPairs

    # Numbers, since the order of a set of texts is another one in every process.
    numbers = [list(range(len(levels))) for levels in FACTORS.values()]
    names = list(FACTORS.values())

    def allowed(chosen: Sequence[int]) -> bool:
        return is_possible([levels[number] for levels, number in zip(names, chosen, strict=False)])

    rows = [
        dict(zip(FACTORS, (levels[number] for levels, number in zip(names, row, strict=True)), strict=True))
        for row in AllPairs(numbers, filter_func=allowed)
    ]
    # What is impossible leaves the array's own search without some pairs that are possible.
    missing = [pair for pair in possible_pairs() if not any(pair <= set(row.items()) for row in rows)]
    while missing:
        rows.append(_row_with(missing))
        missing = [pair for pair in missing if not pair <= set(rows[-1].items())]
    return tuple(rows)


def _row_with(pairs: Sequence[frozenset[tuple[str, str]]]) -> dict[str, str]:
    """Make a row of the first of some pairs, and of as many more as go with it."""
    chosen: dict[str, str] = dict(pairs[0])
    for pair in pairs[1:]:
        together = {**chosen, **dict(pair)}
        if all(together[factor] == level for factor, level in chosen.items()) and _completed(together):
            chosen = together
    row = _completed(chosen)
    assert row is not None, f"no row has {dict(pairs[0])}"
    return row


def _completed(chosen: Row) -> dict[str, str] | None:
    """Give the factors that are left the first level that goes with all the others; None where there is none."""
    row = dict(chosen)
    for factor, levels in FACTORS.items():
        if factor not in row:
            free = [level for level in levels if _goes_with(row, factor, level)]
            if not free:
                return None
            row[factor] = free[0]
    ordered = {factor: row[factor] for factor in FACTORS}
    return ordered if is_possible(tuple(ordered.values())) else None


def _goes_with(row: Row, factor: str, level: str) -> bool:
    return not any(frozenset((item, (factor, level))) in IMPOSSIBLE for item in row.items())
