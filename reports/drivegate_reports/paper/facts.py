"""What the paper publishes beside what the models give, computed when the report is made."""

from __future__ import annotations

from functools import cache

from drivegate_cases.publication.facts import facts
from drivegate_reports.paper.quantities import compared
from drivegate_reports.paper.statements import FIGURE_1, STATEMENTS
from drivegate_reports.paper.verdicts import ComparedStatement


@cache
def comparisons() -> tuple[ComparedStatement, ...]:
    """Compare every published quantity and statement with what the models give."""
    rows: list[ComparedStatement] = []
    for fact in facts():
        rows += [compared(fact, quantity) for quantity in fact.quantities]
        rows += [compare() for compare in STATEMENTS.get(fact.id, ())]
    return tuple(rows)


@cache
def all_comparisons() -> tuple[ComparedStatement, ...]:
    """Compare also what belongs to no fact: the statements on the waveforms of Fig. 1."""
    return (*(compare() for compare in FIGURE_1), *comparisons())
