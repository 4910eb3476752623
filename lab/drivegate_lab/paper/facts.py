"""What the paper publishes beside what the models give, computed when the report is made."""

from __future__ import annotations

from functools import cache

from drivegate_cases.publication import facts
from drivegate_lab.paper.quantities import compared, quantity_keys
from drivegate_lab.paper.statements import FIGURE_1, STATEMENTS
from drivegate_lab.paper.verdicts import ComparedStatement


@cache
def comparisons() -> tuple[ComparedStatement, ...]:
    """Compare what is published of the paper's own drive with what the models give."""
    known = quantity_keys()
    rows: list[ComparedStatement] = []
    for fact in facts():
        rows += [compared(fact, one) for one in fact.quantities if (fact.id, one.name) in known]
        rows += [compare() for compare in STATEMENTS.get(fact.id, ())]
    return tuple(rows)


@cache
def all_comparisons() -> tuple[ComparedStatement, ...]:
    """Compare also what belongs to no fact: the waveforms of Fig. 1."""
    return (*(compare() for compare in FIGURE_1), *comparisons())
