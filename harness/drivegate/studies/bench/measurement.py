"""One measured number with what shows that the work behind it was right, and how times are taken."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from typing import Any, Final, Literal

Better = Literal["more", "less"]
"""Which way a number is better."""

LEAST_ROUND_SECONDS: Final = 0.02
"""Time that one timed round lasts at least (s), so that neither clock nor scheduler is what is measured."""


class NotMeasured(Exception):
    """Something that a measurement needs is not here; the message says what."""


@dataclass(frozen=True)
class Checked:
    """Whether the work that was timed gave the right result.

    Attributes
    ----------
    valid : bool
        Whether it did.
    told : str
        What was looked at, with its numbers.
    """

    valid: bool
    told: str


@dataclass(frozen=True)
class Value:
    """What a measurement gives.

    Attributes
    ----------
    value : float
        The best of all rounds, in the measurement's unit.
    median : float
        Their median; far from the best where the machine was busy.
    rounds : int
        How many there were.
    checked : Checked
        Whether the result was right.
    """

    value: float
    median: float
    rounds: int
    checked: Checked


@dataclass(frozen=True)
class Row:
    """One line of what was measured.

    Attributes
    ----------
    name : str
        Its name, such as ``loop.reference.1500.ideal``.
    title : str
        What it is, for people.
    setting : str
        What the work was; numbers of different settings are not compared.
    unit : str
        The number's unit.
    better : str
        Which way it is better.
    bar : float or None
        What it is meant to reach on an ordinary machine; a bar that is missed is told and is no failure.
    value : Value or None
        The number; None where it was not measured.
    reason : str
        Why it was not.
    """

    name: str
    title: str
    setting: str
    unit: str
    better: Better
    bar: float | None
    value: Value | None
    reason: str = ""

    @property
    def is_invalid(self) -> bool:
        """Whether the work behind the number gave a wrong result."""
        return self.value is not None and not self.value.checked.valid

    def document(self) -> dict[str, Any]:
        """Write the row as plain data."""
        made = self.value
        return {
            "name": self.name,
            "title": self.title,
            "setting": self.setting,
            "unit": self.unit,
            "better": self.better,
            "bar": self.bar,
            "value": None if made is None else made.value,
            "median": None if made is None else made.median,
            "rounds": 0 if made is None else made.rounds,
            "valid": None if made is None else made.checked.valid,
            "check": self.reason if made is None else made.checked.told,
        }


def timed(work: Callable[[], object], clock: Callable[[], float], rounds: int) -> list[float]:
    """Time a piece of work."""
    return interleaved((work,), clock, rounds)[0]


def interleaved(
    works: tuple[Callable[[], object], ...], clock: Callable[[], float], rounds: int
) -> list[list[float]]:
    """Time several pieces of work in turns, so that what disturbs one disturbs the others too."""
    times: list[list[float]] = [[] for _ in works]
    repeats = [_repeats(work, clock) for work in works]
    for _ in range(rounds):
        for work, count, kept in zip(works, repeats, times, strict=True):
            began = clock()
            for _ in range(count):
                work()
            kept.append((clock() - began) / count)
    return times


def _repeats(work: Callable[[], object], clock: Callable[[], float]) -> int:
    began = clock()
    work()
    return max(1, round(LEAST_ROUND_SECONDS / max(clock() - began, 1e-6)))


def rate(amount: float, times: list[float], checked: Checked) -> Value:
    """Turn times into a rate."""
    return Value(amount / min(times), amount / median(times), len(times), checked)


def duration(times: list[float], checked: Checked, scale: float = 1.0) -> Value:
    """Turn times into a duration."""
    return Value(scale * min(times), scale * median(times), len(times), checked)


def ratio(ours: list[float], theirs: list[float], checked: Checked) -> Value:
    """Set times taken in turns against each other: what else runs slows both of a turn, but not every turn."""
    # The best of each may be from different turns.
    middle = median(own / other for own, other in zip(ours, theirs, strict=True))
    return Value(middle, middle, len(ours), checked)
