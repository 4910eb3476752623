"""What runs have reached of a candidate's sources, by file and line, as every tool states it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class Line:
    number: int
    """Number of the line, from 1."""
    count: int
    """How often it ran."""
    branches: tuple[int, ...] = ()
    """How often each way out of it was taken."""


@dataclass(frozen=True)
class SourceFile:
    name: str
    """Its path, from the candidate's folder where it is inside."""
    text: tuple[str, ...]
    lines: tuple[Line, ...]
    """Those that have code, in their order."""


@dataclass(frozen=True)
class Reached:
    """How much was reached, of how much."""

    reached: int
    total: int

    @property
    def percent(self) -> float:
        """Share that was reached (%); all of nothing."""
        return 100.0 * self.reached / self.total if self.total else 100.0

    def in_words(self, noun: str) -> str:
        # Rounded down, so that only all of it is 100 %.
        return f"{self.reached} of {self.total} {noun} ({int(10.0 * self.percent) / 10.0:g} %)"


def reached_lines(files: Iterable[SourceFile]) -> Reached:
    counts = [line.count for file in files for line in file.lines]
    return Reached(sum(count > 0 for count in counts), len(counts))


def reached_branches(files: Iterable[SourceFile]) -> Reached:
    counts = [count for file in files for line in file.lines for count in line.branches]
    return Reached(sum(count > 0 for count in counts), len(counts))
