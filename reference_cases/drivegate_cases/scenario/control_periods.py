"""Times in whole control periods: documents state seconds in decimals, and the loop counts periods.

A control period such as 1/30000 s is no short decimal, and neither are its multiples. So a time in a document is that
of a whole number of control periods where it is close to one, and only this module decides how close that is.
"""

from __future__ import annotations

import math
from typing import Final

ROUNDING: Final = 0.05
"""Distance from the start of a control period within which a time is that start, over the period (1).

It is half of a microsecond, the rounding of times with six decimals, at 100 kHz.
"""
_DIGITS: Final = 9


def whole_periods(time_s: float, control_period_s: float) -> int | None:
    """Return the number of control periods that a time is, or None where that is no whole number."""
    periods = time_s / control_period_s
    nearest = round(periods)
    return nearest if abs(periods - nearest) <= ROUNDING else None


def first_period_from(time_s: float, control_period_s: float) -> int:
    """Return the number of the first control period, from 0, that begins at a time or after it.

    It is also the least number of whole control periods that last for the time.
    """
    whole = whole_periods(time_s, control_period_s)
    return math.ceil(time_s / control_period_s) if whole is None else whole


def period_start_s(number: int, control_period_s: float) -> float:
    """Return when a control period begins, rounded to a nanosecond, as documents can state it."""
    return round(number * control_period_s, _DIGITS)


def on_whole_periods(time_s: float, control_period_s: float) -> float:
    """Return a time, or the next whole number of control periods where it is none."""
    if whole_periods(time_s, control_period_s) is not None:
        return time_s
    return period_start_s(first_period_from(time_s, control_period_s), control_period_s)


def seen_at_s(time_s: float, control_period_s: float) -> float:
    """Return the time of an event as the loop compares it with the starts of its control periods.

    It is never later than the start that it stands for, which the loop computes as the number of the period times its
    length.
    """
    whole = whole_periods(time_s, control_period_s)
    return time_s if whole is None else min(time_s, whole * control_period_s)
