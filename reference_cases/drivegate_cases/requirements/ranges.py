"""Numbers of a scenario that are ranges ``[low, high]``, from which values are drawn."""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import Any, Final, TypeAlias

from drivegate_cases.documents.wording import shown, significant
from drivegate_models.errors import InputError

Choose: TypeAlias = Callable[[float, float], float]
"""From the ends of a range to a value in it."""
_ENDS: Final = 2
_DIGITS: Final = 4
_GREATEST: Final = 1e12
"""Magnitude beyond which no key of a scenario has a value."""
_LISTS_OF_NUMBERS: Final = frozenset({"restarts_s"})
"""Keys that are lists of numbers, so that two of them are no range."""


def has_ranges(table: dict[str, Any]) -> bool:
    found: list[tuple[float, float]] = []

    def note(low: float, high: float) -> float:
        found.append((low, high))
        return low

    with_values(table, note)
    return bool(found)


def draws_of(table: dict[str, Any], count: int, seed: int) -> list[dict[str, Any]]:
    """Return tables with a value for each range: all low, all high, and then drawn ones."""
    random = Random(seed)
    ends: list[Choose] = [lambda low, _: low, lambda _, high: high]
    drawn: list[Choose] = [lambda low, high: significant(random.uniform(low, high), _DIGITS)]
    chosen = (ends + drawn * max(count - _ENDS, 0))[:count]
    return [
        with_values(table, choose) | {"name": f"{table.get('name', 'own')} {number}"}
        for number, choose in enumerate(chosen, start=1)
    ]


def with_values(table: dict[str, Any], choose: Choose) -> dict[str, Any]:
    """Replace every range of a scenario's table by a value in it."""
    return {key: _of_key(key, value, choose) for key, value in table.items()}


def _of_key(key: str, value: Any, choose: Choose) -> Any:
    if isinstance(value, dict):
        return with_values(value, choose)
    if not isinstance(value, list):
        return value
    if key in _LISTS_OF_NUMBERS:
        return [_value(item, choose) for item in value]
    if _is_range(value):
        return _value(value, choose)
    # Points of a course, whose time and value may be ranges, or tables.
    return [
        with_values(item, choose)
        if isinstance(item, dict)
        else [_value(number, choose) for number in item]
        if isinstance(item, list)
        else item
        for item in value
    ]


def _is_range(value: Any) -> bool:
    return isinstance(value, list) and len(value) == _ENDS and all(map(_is_number, value))


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= _GREATEST


def _value(value: Any, choose: Choose) -> Any:
    if not _is_range(value):
        return value
    low, high = value
    if low >= high:
        raise InputError(f"the range {shown(value)} of a scenario must have its lowest value first")
    return choose(float(low), float(high))
