"""What the checks measure on the trace of a run without a position sensor."""

from __future__ import annotations

from math import degrees, pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

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
    below = np.flatnonzero(ahead < least)
    last = int(below[-1]) + 1 if below.size else 0
    reached = last * period if last < len(speed) else float("inf")
    turned = np.cumsum(ahead) * period * pole_pairs
    return Start(reached, max(-float(np.min(turned)), 0.0))


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
    edges = np.flatnonzero(np.diff(np.concatenate(([0], marked.astype(np.int8), [0]))))
    return float(np.max(edges[1::2] - edges[::2])) * period if edges.size else 0.0


def back_after_s(error: Array, band: float, period: float) -> float:
    """Return the time after which an error stays within a band (s); infinite if it is outside at the end."""
    outside = np.flatnonzero(np.abs(error) > band)
    last = int(outside[-1]) + 1 if outside.size else 0
    return last * period if last < len(error) else float("inf")


def time_below_s(speed: Array, least: float, period: float) -> float:
    """Return the time for which a shaft is slower than the least speed, either way (s)."""
    return float(np.count_nonzero(np.abs(speed) < least)) * period
