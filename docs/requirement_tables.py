"""The words of a row as tables: events, statistics, units of time and quantities, from the code that judges by them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from drivegate.contracts.catalogue import CONTRACTS, contract_named
from drivegate_cases.requirements.quantities import QUANTITIES, quantities_of
from drivegate_cases.requirements.row import Row, When
from drivegate_cases.requirements.vocabulary import EVENTS, STATISTICS, TIME_UNITS

Rows = tuple[Sequence[str], list[tuple[str, ...]]]


def row_table(named: str) -> Rows:
    """Return heads and rows of a table: ``keys``, ``when``, ``events``, ``statistics``, ``units`` or ``quantities``."""
    return _MADE[named]()


def _keys(model: type[Row] | type[When]) -> Rows:
    rows = [
        (f"`{key}`", field.description or "", "yes" if field.is_required() else "")
        for key, field in model.model_fields.items()
    ]
    return ("key", "meaning", "must be there"), rows


def _events() -> Rows:
    return ("event", "meaning"), [(f"`{name}`", words) for name, words in EVENTS.items()]


def _statistics() -> Rows:
    return ("statistic", "meaning"), [(f"`{name}`", words) for name, words in STATISTICS.items()]


def _units() -> Rows:
    return ("key", "unit"), [(f"`between_{name}`", unit.words) for name, unit in TIME_UNITS.items()]


def _quantities() -> Rows:
    known = {name: quantities_of(contract_named(name).signal_names) for name in CONTRACTS}
    rows = []
    for quantity in QUANTITIES.values():
        runs = " and ".join(f"`{name}`" for name, listed in known.items() if quantity in listed)
        following = f"runs that follow a {quantity.follows}" if quantity.follows else ""
        meaning = ", ".join(filter(None, (quantity.words, quantity.remark, following)))
        rows.append((f"`{quantity.name}`", meaning, runs))
    return ("quantity", "meaning", "contract"), rows


_MADE: dict[str, Callable[[], Rows]] = {
    "keys": lambda: _keys(Row),
    "when": lambda: _keys(When),
    "events": _events,
    "statistics": _statistics,
    "units": _units,
    "quantities": _quantities,
}
