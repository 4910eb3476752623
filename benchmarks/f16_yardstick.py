"""Search for ground collisions of an F-16 under its recovery autopilot, an example of psy-taliro with 3 coordinates.

    python benchmarks/f16_yardstick.py FOLDER --seeds 50

FOLDER holds the package `aerobench` (AeroBench for Python, Heidlauf and others, ARCH 2018), which is not a part of
drivegate. The methods of psy-taliro need that package. Every trial ends with the first collision or after 300
simulations.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from itertools import repeat
from math import pi, radians
from pathlib import Path
from statistics import fmean, median
from types import MappingProxyType
from typing import Any, Final, TypeAlias

from measured_text import write_measured
from search_figure import TITLES
from search_methods import METHODS, Method, Trial, random_points
from weakening import Point

ALLOWANCE: Final = 300
"""Greatest number of simulations of one trial."""
_DURATION_S: Final = 15.0
_STEP_S: Final = 1.0 / 30.0
_SPEED_FT_S: Final = 540.0
_ANGLE_OF_ATTACK: Final = radians(2.1215)
_ALTITUDE_FT: Final = 2330.0
_POWER: Final = 9.0
_ALTITUDE_PLACE: Final = 11
"""Place of the altitude among the states."""

ANGLES: Final = (
    ("roll", pi / 4.0 - pi / 20.0, pi / 4.0 + pi / 30.0),
    ("pitch", -0.4 * pi, -0.4 * pi + pi / 20.0),
    ("yaw", -pi / 4.0 - pi / 8.0, -pi / 4.0 + pi / 8.0),
)
"""Ranges of the initial angles (rad), those of psy-taliro's example."""

Margin: TypeAlias = Callable[[Point], float]


@cache
def _simulation(folder: str) -> tuple[Any, Any]:
    sys.path.insert(0, folder)
    from aerobench.examples.gcas.gcas_autopilot import GcasAutopilot
    from aerobench.run_f16_sim import run_f16_sim

    return GcasAutopilot, run_f16_sim


@dataclass(frozen=True)
class LeastAltitude:
    """Least altitude of a flight over the initial one; negative below the ground."""

    folder: str

    def __call__(self, point: Point) -> float:
        """Fly from the initial angles of a point of the unit cube."""
        autopilot, run = _simulation(self.folder)
        roll, pitch, yaw = angles(point)
        state = [_SPEED_FT_S, _ANGLE_OF_ATTACK, 0.0, roll, pitch, yaw, *[0.0] * 5, _ALTITUDE_FT, _POWER]
        flown = run(state, _DURATION_S, autopilot(init_mode="roll", stdout=False), _STEP_S)
        return float(flown["states"][:, _ALTITUDE_PLACE].min()) / _ALTITUDE_FT


def angles(point: Point) -> tuple[float, ...]:
    """Return the initial angles at a point of the unit cube (rad)."""
    return tuple(low + (high - low) * place for (_, low, high), place in zip(ANGLES, point, strict=True))


def runs_to_collision(margin: Margin, method: Method, seed: int) -> int | None:
    """Return in which simulation a method first meets a negative margin, None within the allowance."""
    trial = Trial(margin, ALLOWANCE)
    method(trial, len(ANGLES), seed)
    return trial.runs if trial.found else None


def row(name: str, runs: Sequence[int | None]) -> str:
    """Write what the trials of a method came to as a row of a table."""
    found = [run for run in runs if run is not None]
    needed = f"{median(run or ALLOWANCE + 1 for run in runs):g} | {fmean(found):.0f}" if found else "– | –"
    return f"| {name} | {len(found)} of {len(runs)} | {needed} |"


COMPARED: Final[Mapping[str, Method]] = MappingProxyType({**METHODS, "random": random_points})
"""The methods of the comparison of searches, and even draws."""
METHOD_NAMES: Final = ("shard", "bayesian", "alternating", "simplex", "covariance")
"""Those that are tried unless others are named: those of psy-taliro need its package."""


def _trial(folder: str, name: str, seed: int) -> int | None:
    return runs_to_collision(LeastAltitude(folder), COMPARED[name], seed)


HEAD: Final = "| method | found | median | mean of those found |\n|---|---:|---:|---:|"


def main() -> None:
    """Run all trials, print the table, and write it into the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("folder", type=Path, help="folder that holds the package aerobench")
    parser.add_argument("--seeds", type=int, default=50)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--methods", nargs="*", choices=COMPARED, default=METHOD_NAMES)
    parser.add_argument("--page", type=Path, help="page whose table is written again")
    options = parser.parse_args()
    rows = [HEAD]
    sys.stdout.write(f"{HEAD}\n")
    with ProcessPoolExecutor(options.workers) as pool:
        for name in options.methods:
            seeds = range(options.seeds)
            runs = list(pool.map(_trial, repeat(str(options.folder.resolve())), repeat(name), seeds))
            rows.append(row(TITLES[name], runs))
            sys.stdout.write(f"{rows[-1]}\n")
            sys.stdout.flush()
    if options.page is not None:
        write_measured(options.page, "ground collisions", "\n".join(rows))


if __name__ == "__main__":
    main()
