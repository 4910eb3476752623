"""Severities at which a gradual fault breaks its check at a given share of all points, by splitting.

A stronger fault breaks whatever a weaker one breaks; so each point has a least severity at which it fails. A population
of points is pushed to lower and lower ones: the worse part of it is replaced by moved copies of the better, so that
shares far below one over the number of runs are reached (Au and Beck 2001, "Estimation of small failure probabilities
in high dimensions by subset simulation").
"""

from __future__ import annotations

import random
from dataclasses import dataclass
from itertools import pairwise
from math import log
from statistics import stdev

from weakening import Judge, Point, WeakenedFault, on_grid

_BISECTIONS = 6
_KEPT = 0.25
_MOVES = 2
# First step down from a severity at which a point fails, as a share of it; the next ones double.
_FIRST_STEP = 0.02
_LEAST_WIDTH = 0.003
_NEVER = 2.0


@dataclass(frozen=True)
class Rareness:
    """How rare failures are.

    Attributes
    ----------
    severities : list of float
        From the strongest to the weakest.
    shares : list of float
        Share of the points that fail at each.
    runs : int
        Runs that it took to find out.
    """

    severities: list[float]
    shares: list[float]
    runs: int

    def severity(self, share: float) -> float:
        """Interpolate the severity at which a share of the points fails, over the share's logarithm."""
        pairs = list(zip(self.shares, self.severities, strict=True))
        for (more, stronger), (less, weaker) in pairwise(pairs):
            if less <= share <= more:
                part = (log(more) - log(share)) / (log(more) - log(less)) if less < more else 0.0
                return stronger + part * (weaker - stronger)
        raise ValueError(f"no severity fails at a share of {share:.1e}; known are {self.shares}")


class _Population:
    def __init__(self, fault: WeakenedFault, size: int, number: int) -> None:
        self.fault = fault
        self.source = random.Random(number)
        self.runs = 0
        self.size = size

    def fails(self, point: Point, severity: float) -> bool:
        self.runs += 1
        return Judge(self.fault.at(severity), self.fault.check, self.fault.cube).margin(point) < 0.0

    def least(self, point: Point, failing: float) -> float:
        """Find the least severity at which a point fails, below one at which it is known to."""
        step = _FIRST_STEP * failing
        low, high = failing - step, failing
        while low > 0.0 and self.fails(point, low):
            step *= 2.0
            low, high = max(low - step, 0.0), low
        for _ in range(_BISECTIONS):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if self.fails(point, middle) else (middle, high)
        return high

    def drawn(self) -> tuple[float, Point]:
        point = on_grid(tuple(self.source.random() for _ in self.fault.cube.coordinates))
        return (self.least(point, 1.0) if self.fails(point, 1.0) else _NEVER), point

    def moved(self, point: Point, known: float, severity: float, widths: list[float]) -> tuple[float, Point]:
        at, moved = point, False
        for _ in range(_MOVES):
            asked = on_grid(
                tuple(
                    _reflected(place + width * self.source.uniform(-1.0, 1.0))
                    for place, width in zip(at, widths, strict=True)
                )
            )
            if self.fails(asked, severity):
                at, moved = asked, True
        return (self.least(at, severity) if moved else known), at


def _reflected(place: float) -> float:
    inside = abs(place) % 2.0
    return min(inside, 2.0 - inside)


def rareness(fault: WeakenedFault, least_share: float, *, size: int, number: int = 0) -> Rareness:
    """Find the severities of ever smaller shares of failing points."""
    population = _Population(fault, size, number)
    members = sorted(population.drawn() for _ in range(size))
    severities: list[float] = []
    shares: list[float] = []
    share = 1.0
    kept = max(round(_KEPT * size), 2)
    while True:
        for rank in range(size, kept - 1, -1):
            if members[rank - 1][0] < _NEVER:
                severities.append(members[rank - 1][0])
                shares.append(share * rank / size)
        if shares and shares[-1] < least_share:
            return Rareness(severities, shares, population.runs)
        level = members[kept - 1][0]
        if level == _NEVER:
            raise ValueError(f"{fault.name} is hardly ever caught at its strongest")
        share *= kept / size
        survivors = members[:kept]
        widths = [
            max(2.0 * stdev(place), _LEAST_WIDTH)
            for place in zip(*(point for _, point in survivors), strict=True)
        ]
        members = sorted(
            population.moved(point, known, level, widths)
            for known, point in (population.source.choice(survivors) for _ in range(size))
        )
