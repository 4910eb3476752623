"""A published statement beside ours, and the verdict on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

Verdict: TypeAlias = Literal["reproduced", "not reproduced", "open in the paper", "taken as given"]


@dataclass(frozen=True)
class Number:
    """A number with its unit."""

    name: str
    """What it is, such as ``published`` or ``ours``."""
    value: float
    """The number."""
    unit: str
    """Its unit; empty for a pure number."""


@dataclass(frozen=True, kw_only=True)
class ComparedStatement:
    """A published statement beside ours."""

    fact: str
    """Number of the fact, such as ``P8``."""
    quantity: str
    """What is compared."""
    published: str
    ours: str
    """Both with their units."""
    residual: str = ""
    tolerance: str = ""
    """Ours minus the published value, and what is allowed; empty where they have no number."""
    verdict: Verdict
    """``reproduced``, ``not reproduced``, ``open in the paper``, or ``taken as given`` for a value that the model has
    as an input, so that agreement proves nothing."""
    note: str
    """How ours was had."""
    numbers: tuple[Number, ...] = ()
    """The numbers behind the words, for programs."""


def verdict_counts(rows: Sequence[ComparedStatement]) -> tuple[tuple[Verdict, int], ...]:
    """Count the verdicts."""
    verdicts = [row.verdict for row in rows]
    return tuple((verdict, verdicts.count(verdict)) for verdict in get_args(Verdict))
