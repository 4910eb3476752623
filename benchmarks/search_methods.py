"""Ways to look for a counterexample among the points of a unit cube, all with the same allowance of runs.

Each takes a trial, the number of coordinates and a seed, and asks for margins until the trial has ended. `drawing` and
`climbing` are what Hypothesis does by itself, `shard` is what a shard of the gate does. The optimisers are used as they
come.
"""

from __future__ import annotations

import random
import warnings
from collections.abc import Callable
from contextlib import suppress
from importlib.util import find_spec
from types import MappingProxyType
from typing import Any, Final, TypeAlias

import numpy as np
from hypothesis import HealthCheck, Phase, given, seed, settings, target
from hypothesis import strategies as st
from numpy.typing import NDArray

from drivegate.gate.plan import EXAMPLES
from drivegate.gate.shard import SAFE
from drivegate.gate.steps import Search
from drivegate.scenarios.choices import ChoiceSource, Enough, draw_from
from drivegate.scenarios.isolation import from_the_seed_alone
from weakening import GRID, Point, on_grid


class Trial:
    """The runs that one method makes.

    A point asked for again is answered from memory and costs nothing.
    """

    def __init__(
        self, margin: Callable[[Point], float], allowance: int, *, ends_at_failure: bool = True
    ) -> None:
        self._margin = margin
        self._allowance = allowance
        self._ends_at_failure = ends_at_failure
        self._asked = 0
        self._known: dict[Point, float] = {}
        self.found = False

    @property
    def points(self) -> list[Point]:
        """The points run, in their order."""
        return list(self._known)

    @property
    def runs(self) -> int:
        """The number of runs made."""
        return len(self._known)

    def ended(self) -> bool:
        """Whether nothing more is to be asked; a method that only repeats itself has ended too."""
        spent = self.runs >= self._allowance or self._asked >= 20 * self._allowance
        return spent or (self.found and self._ends_at_failure)

    def __call__(self, point: Point) -> float:
        """Return the margin of a point."""
        self._asked += 1
        place = on_grid(point)
        if place not in self._known:
            if self.ended():
                return 1.0
            self._known[place] = self._margin(place)
            self.found = self.found or self._known[place] < 0.0
        return self._known[place]

    def knows(self, point: Point) -> bool:
        """Return True if a point was run."""
        return on_grid(point) in self._known

    @property
    def allowance(self) -> int:
        """The greatest number of runs."""
        return self._allowance


SHARD_ALLOWANCE: Final = EXAMPLES["default"]
"""Runs of a shard of the gate at default effort."""

Method: TypeAlias = Callable[[Trial, int, int], None]
"""From a trial, the number of coordinates and a seed to runs of the trial."""


def _drawn_point(source: random.Random, dimensions: int) -> Point:
    return tuple(source.random() for _ in range(dimensions))


def random_points(trial: Trial, dimensions: int, number: int) -> None:
    """Draw evenly."""
    source = random.Random(number)
    while not trial.ended():
        trial(_drawn_point(source, dimensions))


def _by_hypothesis(
    trial: Trial,
    dimensions: int,
    number: int,
    *,
    climbs: bool,
    allowance: int | None = None,
) -> None:
    most = allowance or trial.allowance

    @seed(number)
    @settings(
        max_examples=most,
        database=None,
        deadline=None,
        phases=(Phase.generate, Phase.target) if climbs else (Phase.generate,),
        suppress_health_check=list(HealthCheck),
    )
    @given(st.tuples(*[st.integers(0, GRID)] * dimensions))
    def explore(steps: tuple[int, ...]) -> None:
        if trial.ended() or trial.runs >= most:
            return
        margin = trial(tuple(step / GRID for step in steps))
        if climbs:
            target(-margin)

    with from_the_seed_alone():
        explore()


def drawing(trial: Trial, dimensions: int, number: int) -> None:
    """Draw with Hypothesis, which likes ends, small numbers and repetitions."""
    _by_hypothesis(trial, dimensions, number, climbs=False)


def climbing(trial: Trial, dimensions: int, number: int) -> None:
    """Draw with Hypothesis, and climb with its target phase."""
    _by_hypothesis(trial, dimensions, number, climbs=True)


def climbing_briefly(trial: Trial, dimensions: int, number: int) -> None:
    """Climb with a shard's runs at default effort; the target phase begins at half of them."""
    _by_hypothesis(trial, dimensions, number, climbs=True, allowance=SHARD_ALLOWANCE)


def shard(trial: Trial, dimensions: int, number: int) -> None:
    """Draw evenly, and step from what came nearest, as a shard of the gate does."""
    search = Search(number)
    source = ChoiceSource(number, search.choices)

    @seed(number)
    @given(st.tuples(*[st.integers(0, GRID)] * dimensions))
    def explore(steps: tuple[int, ...]) -> None:
        if trial.ended():
            raise Enough
        if not source.is_asked:
            return
        point = tuple(step / GRID for step in steps)
        known = trial.knows(point)
        margin = trial(point)
        search.judged(source.made, None if known else {"": margin} if margin < SAFE else {})

    with suppress(Enough):
        draw_from(source, explore, 20 * trial.allowance)


def covariance(trial: Trial, dimensions: int, number: int) -> None:
    """Adapt a covariance matrix (CMA-ES), from another start whenever it has converged."""
    import cma

    source = random.Random(number)
    while not trial.ended():
        options: dict[str, Any] = {"bounds": [0.0, 1.0], "seed": source.randrange(1, 2**31), "verbose": -9}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            search = cma.CMAEvolutionStrategy(_drawn_point(source, dimensions), 0.3, options)
            while not search.stop():
                asked = search.ask()
                search.tell(asked, [trial(tuple(map(float, point))) for point in asked])
                if trial.ended():
                    break


def bayesian(trial: Trial, dimensions: int, number: int) -> None:
    """Model the margins with Parzen estimators (optuna's TPE)."""
    import optuna

    optuna.logging.set_verbosity(optuna.logging.ERROR)
    study = optuna.create_study(sampler=optuna.samplers.TPESampler(seed=number))
    names = [f"x{place}" for place in range(dimensions)]
    while not trial.ended():
        asked = study.ask()
        study.tell(asked, trial(tuple(asked.suggest_float(name, 0.0, 1.0) for name in names)))


def alternating(trial: Trial, dimensions: int, number: int) -> None:
    """Draw evenly and step from the best, in turn; steps grow where they succeed and shrink where they do not."""
    source = random.Random(number)
    best, least, width = _drawn_point(source, dimensions), 1e9, 0.3
    fresh = True
    while not trial.ended():
        if fresh:
            point = _drawn_point(source, dimensions)
        else:
            # Sums of even numbers: nothing here depends on a library of elementary functions.
            point = on_grid(tuple(place + width * (_sum(source)) for place in best))
        margin = trial(point)
        if margin < least:
            width = 0.3 if fresh else min(1.5 * width, 0.3)
            best, least = point, margin
        elif not fresh:
            width = max(0.9 * width, 0.01)
        fresh = not fresh


def _sum(source: random.Random) -> float:
    return source.random() + source.random() + source.random() - 1.5


def _by_taliro(trial: Trial, dimensions: int, number: int, name: str) -> None:
    from staliro import optimizers
    from staliro.signals import Interval

    # Without the package, its classes have no type that another could extend.
    class Asked(optimizers.ObjFunc[float, optimizers.Sample]):  # type: ignore[misc, unused-ignore]
        """Asks the trial."""

        def eval_sample(self, sample: optimizers.Sample) -> float:
            return trial(tuple(map(float, sample.values)))

    optimizer = {"uniform": optimizers.UniformRandom, "annealing": optimizers.DualAnnealing}[name](
        min_cost=0.0
    )
    bounds = [Interval(0.0, 1.0)] * dimensions
    seeds = random.Random(number)
    # It counts points that are asked for again too, and so may end before the trial.
    while not trial.ended():
        optimizer.optimize(Asked(), optimizers.Optimizer.Params(number, trial.allowance, bounds))
        number = seeds.randrange(2**31)


def uniform(trial: Trial, dimensions: int, number: int) -> None:
    """Draw as psy-taliro does."""
    _by_taliro(trial, dimensions, number, "uniform")


def annealing(trial: Trial, dimensions: int, number: int) -> None:
    """Anneal as psy-taliro does."""
    _by_taliro(trial, dimensions, number, "annealing")


def simplex(trial: Trial, dimensions: int, number: int) -> None:
    """Move a simplex (Nelder and Mead), from another start whenever it has converged."""
    from scipy.optimize import minimize

    def asked(point: NDArray[np.float64]) -> float:
        return trial(tuple(map(float, point)))

    source = random.Random(number)
    while not trial.ended():
        start = np.array([source.random() for _ in range(dimensions)])
        options: Any = {"xatol": 1.0 / GRID, "maxfev": trial.allowance - trial.runs}
        minimize(asked, start, method="Nelder-Mead", bounds=[(0.0, 1.0)] * dimensions, options=options)


METHODS: Final = MappingProxyType(
    {
        "drawing": drawing,
        "climbing": climbing,
        "climbing-briefly": climbing_briefly,
        "shard": shard,
        "covariance": covariance,
        "bayesian": bayesian,
        "alternating": alternating,
        "simplex": simplex,
        "uniform": uniform,
        "annealing": annealing,
    }
)
"""The methods that make runs; what even drawing needs is known from how rare the failure is."""
_PACKAGES: Final = {"covariance": "cma", "bayesian": "optuna", "uniform": "staliro", "annealing": "staliro"}
INSTALLED: Final = tuple(
    method for method in METHODS if method not in _PACKAGES or find_spec(_PACKAGES[method]) is not None
)
"""Those whose package is there; drivegate requires none of these packages."""
