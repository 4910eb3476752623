"""A course of few points, which keeps the extremes of what it was made from."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.checks.margin import GREATEST, Course
from drivegate_cases.documents.wording import significant

MOST_POINTS: Final = 600
"""Greatest number of points of a course, but for its first."""
DIGITS: Final = 6
"""Significant digits of the values of a course."""
_TIME_DIGITS: Final = 9


def course_of(words: str, time_s: NDArray[Any], values: NDArray[Any]) -> Course:
    """Make a course of few points: the first one, and the least and the greatest of each of equal parts."""
    # A controller may answer with anything.
    values = np.clip(np.nan_to_num(values), -GREATEST, GREATEST)
    places = np.arange(len(values))
    if len(values) > MOST_POINTS:
        parts = np.array_split(places, MOST_POINTS // 2)
        extremes = {part[index(values[part])] for part in parts for index in (np.argmin, np.argmax)}
        places = np.array(sorted({0, *map(int, extremes)}))
    return Course(
        words=words,
        time_s=tuple(significant(float(time), _TIME_DIGITS) for time in time_s[places]),
        values=tuple(significant(float(value), DIGITS) for value in values[places]),
    )
