"""Trials of the comparison of searches: levels, allowances, and one piece of work."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

from rare_severities import rareness
from search_methods import INSTALLED, METHODS, Trial
from weakened_faults import FAULTS
from weakening import Cube, Judge, Point, WeakenedFault, correct

COMPARED: Final = tuple(method for method in INSTALLED if method != "uniform")
"""Methods that are compared; psy-taliro's uniform draws are even ones, of which all is known without a trial."""
LEVELS: Final = 4
"""Number of levels of each fault."""
SLOW_CHECKS: Final = ("ROB-1", "CNV-1")
"""Checks that judge runs of 9 s and more; their trials are shorter."""
SEEDS: Final = range(20)
"""Seeds of each method."""


def expected_draws(level: int) -> float:
    """Return the runs that drawing evenly needs on average at a level: from a hundred to a hundred thousand."""
    return 10.0 ** (2 + level)


@dataclass(frozen=True)
class Cell:
    """A piece of work: how rare the failures of a fault with a size are, or the trials of one method and seed.

    Attributes
    ----------
    fault : int
        Number of the fault.
    method : str
        The method; empty for the rareness.
    seed : int
        Seed of the method.
    level : int
        Level; -1 for all of them at once, as of sudden faults.
    severity : float
        Severity at that level.
    """

    fault: int
    method: str = ""
    seed: int = 0
    level: int = -1
    severity: float = 0.0

    @property
    def key(self) -> str:
        """Name in the result file."""
        parts = (FAULTS[self.fault].name, self.method, self.level, self.seed)
        return "/".join(map(str, parts)) if self.method else FAULTS[self.fault].name


def allowance(fault: WeakenedFault) -> int:
    """Return the greatest number of runs of one trial."""
    if fault.check in SLOW_CHECKS:
        return 100
    return 500 if fault.shape == "sudden" else 300


@cache
def _points(check: str, cube: Cube, method: str, seed: int, most: int) -> list[Point]:
    """Return the points that a method runs the correct controller at; faults of one check and cube share them."""
    trial = Trial(correct(check, cube).margin, most, ends_at_failure=False)
    METHODS[method](trial, len(cube.coordinates), seed)
    return trial.points


def done(cell: Cell) -> tuple[str, dict[str, Any]]:
    """Do a piece of work; this is what the worker process does."""
    begun = time.process_time()
    fault = FAULTS[cell.fault]
    if not cell.method:
        found = rareness(fault, 0.5e-5, size=24 if fault.check in SLOW_CHECKS else 64)
        levels = [found.severity(1.0 / expected_draws(level)) for level in range(LEVELS)]
        outcome: dict[str, Any] = {"severities": levels, "runs": found.runs}
    elif fault.shape != "sudden":
        judge = Judge(fault.at(cell.severity), fault.check, fault.cube)
        trial = Trial(judge.margin, allowance(fault))
        METHODS[cell.method](trial, len(fault.cube.coordinates), cell.seed)
        outcome = {"runs": trial.runs, "found": trial.found}
    else:
        points = _points(fault.check, fault.cube, cell.method, cell.seed, allowance(fault))
        outcome = {"runs": len(points), "first": first_in_pockets(fault, points)}
    return cell.key, {**outcome, "seconds": round(time.process_time() - begun, 3)}


def first_in_pockets(fault: WeakenedFault, points: Iterable[Point]) -> list[int | None]:
    """Return the run in which each level's pocket was first met and the fault was caught there.

    Outside of the pocket the faulty controller is the correct one, whatever the pocket's size; so one course of
    runs of that one serves all levels.
    """
    faulty = Judge(fault.at(1.0), fault.check, fault.cube)
    widths = [fault.half_width(1.0 / expected_draws(level)) for level in range(LEVELS)]
    first: list[int | None] = [None] * LEVELS
    for run, point in enumerate(points, start=1):
        open_levels = [
            level
            for level, width in enumerate(widths)
            if first[level] is None and fault.distance(point) <= width
        ]
        if open_levels and faulty.margin(point) < 0.0:
            for level in open_levels:
                first[level] = run
    return first
