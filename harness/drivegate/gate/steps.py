"""Steps from what came nearest: choices of a scenario changed one at a time, toward a smaller margin of one check."""

from __future__ import annotations

from bisect import insort
from collections.abc import Mapping
from math import inf
from random import Random
from typing import Final

from drivegate.scenarios.choices import Choices

_FIRST_STEP: Final = 0.25
_LEAST_STEP: Final = 0.004
"""First and least step over the range of a number (1)."""
_LEAST_GROWTH: Final = 0.3
_GROWTH: Final = 4.0
_BEYOND: Final = 1.2
"""What a step scales with: the way to the limit where the margin is a line, and somewhat more (1)."""
_SHRINKAGE: Final = 0.4
_JOINT_SHRINKAGE: Final = 0.7
_END_SHARE: Final = 0.2
"""Share of steps that bring one choice to an end of its range, since the way there may lead over a hill."""
_SINGLE_SHARE: Final = 0.48
_PAIR_SHARE: Final = 0.2
"""Shares of steps that move one choice and two; the others move all."""
_KEPT: Final = 8
"""Number of draws kept to start from."""
_PRICE: Final = 0.1
"""What every step without success adds to a check's distance where the nearest check is chosen (1)."""


class Climb:
    """Moves one choice, two or all at a time while a margin falls, and others after that.

    Numbers are moved both ways by a step that grows on success and shrinks on failure, as Hooke and Jeeves move
    ("Direct search solution of numerical and statistical problems", Journal of the ACM 8(2), 1961), or to an end of
    their range; an alternative is replaced by another.
    """

    def __init__(self, start: Choices, margin: float, source: Random) -> None:
        self._source = source
        self.best, self.margin = start, margin
        self._begin()

    def _begin(self) -> None:
        self._steps = [_FIRST_STEP] * len(self.best)
        self._joint_step = _FIRST_STEP
        self._order: list[int] = []
        self._turn()

    @property
    def is_over(self) -> bool:
        """Whether every number was moved by its least step in vain."""
        return all(step < _LEAST_STEP for step in self._steps)

    def _turn(self) -> None:
        """Choose what is moved next, and which way."""
        count = len(self.best)
        self._order = [place for place in self._order if self._steps[place] >= _LEAST_STEP]
        if not self._order:
            self._order = [place for place, step in enumerate(self._steps) if step >= _LEAST_STEP]
            self._source.shuffle(self._order)
        kind = self._source.random()
        # Those that change nothing have no step.
        moving = [place for place, step in enumerate(self._steps) if step > 0.0]
        self._is_to_end = kind < _END_SHARE and bool(moving)
        if self._is_to_end:
            places = [self._source.choice(moving)]
        elif kind < _END_SHARE + _SINGLE_SHARE or count < 2:
            places = [self._order.pop()] if self._order else []
        elif kind < _END_SHARE + _SINGLE_SHARE + _PAIR_SHARE:
            places = self._source.sample(range(count), 2)
        else:
            places = list(range(count))
        few = len(places) <= 2
        self._direction = {
            place: (1.0 if self._source.random() < 0.5 else -1.0)
            if few
            else 2.0 * self._source.random() - 1.0
            for place in places
        }
        self._turned = False

    def next(self) -> Choices:
        """Return the choices of the next step; those of the best where there is none."""
        for _ in range(4 * len(self.best)):
            if (changed := self._changed()) != self.best:
                return changed
            self.failed()
        return self.best

    def _length(self, place: int) -> float:
        return self._steps[place] if len(self._direction) == 1 else self._joint_step

    def _changed(self) -> Choices:
        made = list(self.best)
        for place, sense in self._direction.items():
            choice = made[place]
            size = choice.greatest - choice.least
            if choice.is_number:
                move = sense * (1.0 if self._is_to_end else self._length(place)) * size
                if choice.is_whole and len(self._direction) == 1:
                    move = sense * max(abs(move), 1.0)
                made[place] = choice.at(choice.value + move)
            elif len(self._direction) == 1:
                made[place] = choice.at(choice.least + int(self._source.random() * (size + 1.0)))
        return tuple(made)

    def succeeded(self, made: Choices, margin: float) -> None:
        """Go on from a better scenario in the same direction, as far as the limit seems to be."""
        gained, changed = self.margin - margin, len(made) != len(self.best)
        self.best, self.margin = made, margin
        if changed:
            # An alternative with other numbers.
            self._begin()
            return
        self._scale(min(max(_BEYOND * margin / gained, _LEAST_GROWTH), _GROWTH))
        self._turned = True

    def failed(self, margin: float = inf) -> None:
        """Try the other way, and after that other numbers; one that changes nothing is not moved again."""
        lost = margin - self.margin
        if lost == 0.0 and len(self._direction) == 1:
            self._scale(0.0)
            self._turn()
        elif not self._turned and any(self.best[place].is_number for place in self._direction):
            self._direction = {place: -sense for place, sense in self._direction.items()}
            self._turned = True
            # Where the margin is a line, the limit is so far the other way.
            if 0.0 < lost < inf:
                self._scale(min(max(_BEYOND * self.margin / lost, _SHRINKAGE), 1.0))
        else:
            self._scale(_SHRINKAGE if len(self._direction) == 1 else _JOINT_SHRINKAGE)
            self._turn()

    def _scale(self, factor: float) -> None:
        if self._is_to_end and factor > 0.0:
            return
        if len(self._direction) == 1:
            (place,) = self._direction
            self._steps[place] = min(factor * self._steps[place], 1.0)
        else:
            self._joint_step = max(min(factor * self._joint_step, 0.5), _LEAST_STEP)


class Nearest:
    """What came nearest to the limit of each check, and the climb that goes on from it."""

    def __init__(self, source: Random) -> None:
        self._source = source
        self._draws: dict[str, list[tuple[float, Choices]]] = {}
        self._climbs: dict[str, Climb] = {}
        self._failures: dict[str, int] = {}
        self._drawn: dict[str, list[float]] = {}
        self._count = 0

    def drew(self, margins: Mapping[str, float]) -> None:
        """Learn from an even draw what margins of each check are usual; one that is not near has none."""
        self._count += 1
        for check, margin in margins.items():
            insort(self._drawn.setdefault(check, []), margin)

    def _distance(self, check: str, margin: float) -> float:
        """Return a margin over what usual ones are above it, infinite where nothing moves it."""
        drawn, middle = self._drawn.get(check, ()), self._count // 2
        usual = drawn[middle] if middle < len(drawn) else 1.0
        return margin / (usual - margin) if usual > margin else inf

    def met(self, made: Choices, margins: Mapping[str, float]) -> None:
        """Keep a scenario for the checks that it came near to."""
        for check, margin in margins.items():
            draws = self._draws.setdefault(check, [])
            draws.append((margin, made))
            draws.sort(key=lambda draw: draw[0])
            del draws[_KEPT:]

    def check(self) -> str | None:
        """Choose the check to climb toward: unusually near, not often tried in vain, and not broken yet."""
        open_checks = {check: draws[0][0] for check, draws in self._draws.items() if draws}
        open_checks |= {
            check: climb.margin
            for check, climb in self._climbs.items()
            if climb.margin < open_checks.get(check, 1.0)
        }
        costs = {
            check: self._distance(check, margin) + _PRICE * self._failures.get(check, 0)
            for check, margin in open_checks.items()
            if margin >= 0.0
        }
        return min((check for check in costs if costs[check] < inf), key=costs.__getitem__, default=None)

    def step(self, check: str) -> Choices:
        """Return the choices of the next step toward a check's limit."""
        climb, draws = self._climbs.get(check), self._draws.get(check, [])
        if draws and (climb is None or climb.is_over or draws[0][0] < climb.margin):
            margin, start = draws.pop(0)
            climb = self._climbs[check] = Climb(start, margin, self._source)
        assert climb is not None, "a check is chosen where something came near it"
        return climb.next()

    def stepped(self, check: str, made: Choices, margin: float | None) -> bool:
        """Take the margin of a step, None where the scenario is no new one; return True if it came nearer."""
        climb = self._climbs[check]
        if margin is not None and margin < climb.margin:
            climb.succeeded(made, margin)
            return True
        climb.failed(inf if margin is None else margin)
        self._failures[check] = self._failures.get(check, 0) + 1
        return False


class Search:
    """Even draws, and after a draw steps for as long as they come nearer."""

    def __init__(self, seed: int) -> None:
        self._nearest = Nearest(Random(seed))
        self.stepping: str | None = None
        self._is_due = False

    def choices(self) -> Choices:
        """Return the choices of the next scenario: those of a step, or none for a draw."""
        self.stepping = self._nearest.check() if self._is_due else None
        return self._nearest.step(self.stepping) if self.stepping is not None else ()

    def judged(self, made: Choices, margins: Mapping[str, float] | None) -> None:
        """Take the margins of the last scenario by check; None where it showed nothing new."""
        stepping = self.stepping
        if margins is not None:
            # A step toward one check may come near another.
            self._nearest.met(made, {check: margins[check] for check in margins if check != stepping})
        if stepping is not None:
            near = None if margins is None else margins.get(stepping)
            self._is_due = self._nearest.stepped(stepping, made, near)
        elif margins is not None:
            self._is_due = True
            self._nearest.drew(margins)
