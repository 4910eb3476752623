"""What the checks measure on the trace of a run without a position sensor."""

from __future__ import annotations

from math import degrees, pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate.checks.stretches import lasting_from, stretches

Array = NDArray[np.float64]


class Start(NamedTuple):
    """How a shaft starts."""

    reached: float
    """Time after which the speed stays at the least one or above, shape () (s); infinite if it never does."""
    backward: float
    """Greatest turn against the sense of the start (electrical rad)."""


def start_of(speed: Array, least: float, sense: float, pole_pairs: int, period: float) -> Start:
    """Measure a start from standstill.

    Parameters
    ----------
    speed : ndarray, shape (n,)
        Speed of the shaft in each control period (rad/s).
    least : float
        Least speed (rad/s).
    sense : float
        1 forward, -1 backward.
    pole_pairs : int
    period : float
        Control period (s).
    """
    ahead = sense * speed
    turned = np.cumsum(ahead) * period * pole_pairs
    return Start(_lasting_after_s(ahead >= least, period), max(-float(np.min(turned)), 0.0))


def angle_errors(estimate: Array, angle: Array, pole_pairs: int) -> Array:
    """Return the error of the estimated angle of a shaft (rad), shape (n,), within half an electrical turn.

    `angle` is the electrical angle at the start of each control period (rad).
    """
    turns = (pole_pairs * estimate - angle) / (2.0 * pi)
    errors: Array = 2.0 * pi * (turns - np.round(turns))
    return errors


def mean_and_peak_deg(errors: Array) -> tuple[float, float]:
    """Return the size of the mean and the greatest size of angle errors (electrical degrees).

    Errors near half a turn are of either sign, so their mean is taken around the first one.
    """
    turn = 2.0 * pi
    apart = errors - errors[0]
    mean = float(errors[0] + np.mean(apart - turn * np.round(apart / turn)))
    mean -= turn * round(mean / turn)
    return degrees(abs(mean)), degrees(float(np.max(np.abs(errors))))


def longest_s(marked: NDArray[np.bool_], period: float) -> float:
    """Return the length of the longest unbroken stretch of marked control periods (s)."""
    return max((last - first for first, last in stretches(marked)), default=0) * period


def back_after_s(error: Array, band: float, period: float) -> float:
    """Return the time after which an error stays within a band (s); infinite if it is outside at the end."""
    return _lasting_after_s(np.abs(error) <= band, period)


def _lasting_after_s(inside: NDArray[np.bool_], period: float) -> float:
    """Return the time after which all control periods are inside (s); infinite if the last one is not."""
    first = lasting_from(inside)
    return first * period if first < len(inside) else float("inf")


def time_below_s(speed: Array, least: float, period: float) -> float:
    """Return the time for which a shaft is slower than the least speed, either way (s)."""
    return float(np.count_nonzero(np.abs(speed) < least)) * period
