"""One measured number with what shows that the work behind it was right, and how times are taken."""

from __future__ import annotations

import gc
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from timeit import Timer
from typing import Final, Literal

Better = Literal["more", "less"]
"""Which way a number is better."""

LEAST_ROUND_SECONDS: Final = 0.02
"""Time that one timed round lasts at least (s), so that neither clock nor scheduler is what is measured."""


class NotMeasured(Exception):
    """Something that a measurement needs is not here; the message says what."""


@dataclass(frozen=True)
class Correctness:
    """Whether the work that was timed gave the right result."""

    valid: bool
    """Whether it did."""
    measured: str
    """What was looked at, with its numbers."""


@dataclass(frozen=True)
class Value:
    """What a measurement gives."""

    value: float
    """The best of all rounds, in the measurement's unit."""
    median: float
    """Their median; far from the best where the machine was busy."""
    rounds: int
    """How many there were."""
    correctness: Correctness
    """Whether the result was right."""


def timed(work: Callable[[], object], clock: Callable[[], float], rounds: int) -> list[float]:
    """Time a piece of work."""
    return interleaved((work,), clock, rounds)[0]


def interleaved(
    works: tuple[Callable[[], object], ...], clock: Callable[[], float], rounds: int
) -> list[list[float]]:
    """Time several pieces of work in turns, so that what disturbs one disturbs the others too."""
    # The collector of garbage, which a timer turns off, is part of what a candidate in Python costs.
    timers = [Timer(work, setup=gc.enable, timer=clock) for work in works]
    repeats = [max(1, round(LEAST_ROUND_SECONDS / max(timer.timeit(1), 1e-6))) for timer in timers]
    times: list[list[float]] = [[] for _ in works]
    for _ in range(rounds):
        for timer, count, kept in zip(timers, repeats, times, strict=True):
            kept.append(timer.timeit(count) / count)
    return times


def rate(amount: float, times: list[float], correctness: Correctness) -> Value:
    """Turn times into a rate."""
    return Value(amount / min(times), amount / median(times), len(times), correctness)


def duration(times: list[float], correctness: Correctness, scale: float = 1.0) -> Value:
    """Turn times into a duration."""
    return Value(scale * min(times), scale * median(times), len(times), correctness)


def ratio(ours: list[float], theirs: list[float], correctness: Correctness) -> Value:
    """Set times taken in turns against each other: what else runs slows both of a turn, but not every turn."""
    # The best of each may be from different turns.
    middle = median(own / other for own, other in zip(ours, theirs, strict=True))
    return Value(middle, middle, len(ours), correctness)
