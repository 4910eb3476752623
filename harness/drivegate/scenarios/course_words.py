"""The course of a quantity over time in words: its values, and when they change."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Final, TypeAlias

from drivegate_cases.documents.wording import figure

Course: TypeAlias = Sequence[Sequence[float]]
"""Points of time (s) and value."""
_LISTED_TURNS: Final = 2


def levels(profile: Course) -> list[float]:
    """Values that a profile goes through, without immediate repetitions."""
    values = [value for _, value in profile]
    return [value for place, value in enumerate(values) if place == 0 or value != values[place - 1]]


def sequence(values: list[float], scale: float = 1.0) -> str:
    """Join values; what goes to and fro again and again is said once."""
    turns = len(values) // 2
    words = [figure(scale * value) for value in values]
    if turns > _LISTED_TURNS and values == (values[:2] * (turns + 1))[: len(values)]:
        return "-".join([f"{words[0]}-{words[1]}×{turns}", *words[2 * turns :]])
    return "-".join(words)


def in_words(values: list[float], unit: str, scale: float = 1.0) -> str:
    return f"{', then '.join(figure(scale * value) for value in values)} {unit}"


def changing(profile: Course, unit: str, scale: float = 1.0) -> str:
    """State the values of a course, and when they change."""
    return f"{in_words(levels(profile), unit, scale)}{change_times(profile)}"


def change_times(profile: Course) -> str:
    """State in brackets when a course changes."""
    changes = [time for (time, value), (_, after) in pairwise(profile) if value != after]
    return f" (changing at {', '.join(f'{time:.4g}' for time in changes)} s)" if changes else ""


def changes_at(profile: Course, unit: str, scale: float = 1.0) -> str:
    """State the values of a profile, and when they change, as a fact."""
    times = dict.fromkeys(f"{before[0]:g}" for before, after in pairwise(profile) if before[1] != after[1])
    words = f"{' → '.join(figure(scale * value) for value in levels(profile))} {unit}"
    return f"{words} at {', '.join(times)} s" if times else words


def arrows(profile: Course) -> str:
    """State the values of a course with an arrow for each change."""
    return " → ".join(f"{value:g}" for value in levels(profile))


def listed(profile: Course) -> list[list[float]]:
    """Return a course as lists of numbers, which compare whatever it was read from."""
    return [[float(number) for number in point] for point in profile]
