"""A row as a check, with the same registration and margins as any other."""

from __future__ import annotations

from functools import lru_cache, partial
from typing import Final

from drivegate.checks.check import Check
from drivegate.contracts.contract import Contract
from drivegate.contracts.rows.judging import margin_of, moment_of, named_statistic
from drivegate.contracts.rows.nearness import nearness
from drivegate_cases.documents.wording import figure
from drivegate_cases.requirements.quantities import QUANTITIES
from drivegate_cases.requirements.row import Row, When
from drivegate_cases.requirements.vocabulary import TIME_UNITS

SOURCE: Final = "own requirement"
"""What a row is based on."""
_KEPT: Final = 1000
_UNITS: Final = {"time until": " s", "sign changes": ""}


@lru_cache(maxsize=_KEPT)
def row_check(contract: Contract, row: Row) -> Check:
    """Return the check that judges runs of a contract by a row."""
    return Check(
        id=row.id,
        requirement=_plain(row.text),
        source=SOURCE,
        level=row.level,
        limit=_plain(limit_in_words(row)),
        scenarios=_plain(window_in_words(row)),
        formula="distance from the limit / the limit, or half of the range",
        why="It is a requirement of the product.",
        every_run=True,
        evaluate=partial(margin_of, row, contract),
        moment=partial(moment_of, row, contract),
        nearness=partial(nearness, row, contract),
        row=row,
    )


def _plain(text: str) -> str:
    """Write a text of a user so that no brace in it is taken for the name of a drive's number."""
    return text.replace("{", "{{").replace("}", "}}")


def limit_in_words(row: Row) -> str:
    """Return what of the quantity is allowed."""
    quantity = QUANTITIES[row.quantity]
    unit = _UNITS.get(row.statistic, f" {quantity.unit}")
    low, high = row.limits
    if low is not None and high is not None:
        limit = f"from {figure(low)} to {figure(high)}{unit}"
    else:
        limit = f"at least {figure(low)}{unit}" if low is not None else f"at most {figure(high or 0.0)}{unit}"
    named = named_statistic(row)
    if row.until is not None:
        reached = f"{figure(row.until[0])} to {figure(row.until[1])} {quantity.unit}"
        named = f"time until the {quantity.words} is from {reached}"
    for length, words in ((row.for_s, "s"), (row.for_periods, "control periods")):
        limit += "" if length is None else f" for {figure(length)} {words}"
    return f"{named} {limit}"


def window_in_words(row: Row) -> str:
    """Return where a row is judged."""
    when = row.when
    subject = when.event or ("stretch" if when.has_state else "run")
    unit, (begin, end) = row.window
    after = ""
    if begin or end is not None:
        upper = "" if end is None else f" to {figure(end)}"
        after = f", from {figure(begin)}{upper} {TIME_UNITS[unit].words} after it begins"
    return f"every {subject}{_state_in_words(when)}{after}"


def _state_in_words(when: When) -> str:
    ranges = [f"{name} from {figure(low)} to {figure(high)}" for name, (low, high) in when.ranges().items()]
    if when.step_percent is not None:
        ranges.insert(0, f"a size from {figure(when.step_percent[0])} to {figure(when.step_percent[1])} %")
    words = f" with {' and '.join(ranges)}" if ranges else ""
    return words if when.direction is None else f"{words} while the shaft turns {when.direction}"
