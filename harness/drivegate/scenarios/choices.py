"""Scenarios drawn evenly over their families, and drawn again with some choices changed.

A strategy makes a scenario from a row of choices: whole numbers and numbers within bounds. Hypothesis asks a backend of
its own for each of them (`hypothesis.internal.conjecture.providers.PrimitiveProvider`, its documented interface for
alternative backends), so that the same strategies serve even draws and steps.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import inf, isfinite
from random import Random
from typing import Any, Final, NamedTuple, TypeAlias
from unittest import mock

from hypothesis import HealthCheck, Phase, settings
from hypothesis.internal.conjecture import providers

from drivegate.scenarios.isolation import from_the_seed_alone

STRATA: Final = 16
"""Parts of a range of which each gives one value, in random order, before any gives another."""
BOUNDARY_SHARE: Final = 1.0 / 6.0
"""Share of draws in which half of the numbers are an end of their range."""
_OTHERS: Final = 2**32
"""What parts the seed of the numbers that are drawn beside given ones from those of all shards."""
_BACKEND: Final = "drivegate"


class Enough(BaseException):
    """Ends the drawing of scenarios: no failure of a test, which Hypothesis would run again."""


class Choice(NamedTuple):
    """One number that a scenario is made from."""

    value: float
    least: float
    greatest: float
    is_whole: bool

    @property
    def is_number(self) -> bool:
        """Whether its neighbours are likely to be similar; few whole numbers count alternatives."""
        return not self.is_whole or self.greatest - self.least >= STRATA

    def at(self, value: float) -> Choice:
        """Return another value within the same bounds."""
        inside = min(max(value, self.least), self.greatest)
        return self._replace(value=round(inside) if self.is_whole else inside)


Choices: TypeAlias = tuple[Choice, ...]


class EvenDraws:
    """Draws numbers evenly over their ranges: each number in the row of choices has its own strata.

    All arithmetic is exact on every processor.
    """

    def __init__(self, seed: int) -> None:
        self._source = Random(seed)
        self._strata: dict[tuple[int, float, float, bool], list[int]] = {}
        self._at_ends = False

    def begin(self) -> None:
        """Begin another scenario."""
        self._at_ends = self._source.random() < BOUNDARY_SHARE

    def choice(self, place: int, least: float, greatest: float, *, is_whole: bool) -> Choice:
        blank = Choice(least, least, greatest, is_whole)
        if blank.is_number and self._at_ends and self._source.random() < 0.5:
            return blank.at(greatest if self._source.random() < 0.5 else least)
        size = greatest - least + is_whole
        parts = STRATA if blank.is_number else int(size)
        left = self._strata.setdefault((place, least, greatest, is_whole), [])
        if not left:
            left.extend(range(parts))
            self._source.shuffle(left)
        offset = (left.pop() + self._source.random()) / parts * size
        return blank.at(least + (int(offset) if is_whole else offset))


class ChoiceSource:
    """What the next scenario is made from: choices that are given, and even draws for all others.

    Scenarios of even draws alone are the same ones, in the same order, whatever is given between them.
    """

    def __init__(self, seed: int, given: Callable[[], Choices]) -> None:
        self._whole, self._rest = EvenDraws(seed), EvenDraws(seed + _OTHERS)
        self._draws = self._whole
        self._given = given
        self._wanted: Choices = ()
        self._made: list[Choice] | None = None

    @property
    def is_asked(self) -> bool:
        """Whether the last scenario was made from choices of this source."""
        return self._made is not None

    @property
    def made(self) -> Choices:
        """The choices of the last scenario."""
        return tuple(self._made or ())

    def begin(self) -> None:
        self._made = []
        self._wanted = self._given()
        self._draws = self._rest if self._wanted else self._whole
        self._draws.begin()

    def choose(self, least: float, greatest: float, *, is_whole: bool) -> float:
        assert self._made is not None, "a scenario is begun first"
        place = len(self._made)
        choice = self._wanted[place] if place < len(self._wanted) else None
        if choice is None or (choice.least, choice.greatest, choice.is_whole) != (least, greatest, is_whole):
            # Behind a choice with other bounds, what is left of those given is of another row.
            self._wanted = ()
            choice = self._draws.choice(place, least, greatest, is_whole=is_whole)
        self._made.append(choice)
        return choice.value


def draw_from(source: ChoiceSource, explore: Callable[[], None], most: int) -> None:
    """Have Hypothesis call a test of its own with what it makes from a source, so many times at most.

    The test may raise `Enough`, which is passed on.
    """
    with from_the_seed_alone(), _backend_of(source) as backend:
        settings(
            max_examples=most,
            backend=backend,
            database=None,
            deadline=None,
            phases=(Phase.generate,),
            suppress_health_check=list(HealthCheck),
        )(explore)()


@contextmanager
def _backend_of(source: ChoiceSource) -> Iterator[str]:
    """Let Hypothesis take its choices from a source; gives the name of the backend for its settings."""

    class Backend(providers.PrimitiveProvider):
        """Asks the source for numbers; strategies of scenarios draw nothing else."""

        @contextmanager
        def per_test_case_context_manager(self) -> Iterator[None]:
            source.begin()
            yield

        def draw_boolean(self, p: float = 0.5) -> bool:
            return p == 1.0 or (p > 0.0 and source.choose(0.0, 1.0, is_whole=False) < p)

        def draw_integer(self, min_value: int | None = None, max_value: int | None = None, **_: Any) -> int:
            assert min_value is not None, "scenarios are drawn within bounds"
            assert max_value is not None, "scenarios are drawn within bounds"
            return int(source.choose(min_value, max_value, is_whole=True))

        def draw_float(self, *, min_value: float = -inf, max_value: float = inf, **_: Any) -> float:
            assert isfinite(min_value), "scenarios are drawn within bounds"
            assert isfinite(max_value), "scenarios are drawn within bounds"
            return source.choose(min_value, max_value, is_whole=False)

        def draw_string(self, *_: Any, **__: Any) -> str:
            raise NotImplementedError

        def draw_bytes(self, *_: Any, **__: Any) -> bytes:
            raise NotImplementedError

    with mock.patch.dict(providers.AVAILABLE_PROVIDERS, {_BACKEND: Backend}):
        yield _BACKEND
