"""Steps toward a smaller margin: within bounds, never away from the best, and not toward one check alone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivegate.gate.steps import Climb, Search
from drivegate.scenarios.choices import Choice, Choices, EvenDraws

Margin = Callable[[Choices], float]


def _start(count: int, source: Random) -> Choices:
    return tuple(Choice(source.randint(0, 1000), 0, 1000, is_whole=True) for _ in range(count))


def _shares(made: Choices) -> list[float]:
    return [choice.value / 1000.0 for choice in made]


def _runs_to_failure(margin: Margin, seed: int, most: int, count: int = 4) -> int:
    """Count the runs of a search until a margin is negative, `most` if none is."""
    search, draws = Search(seed), EvenDraws(seed)
    for run in range(1, most):
        made = search.choices()
        if not made:
            draws.begin()
            made = tuple(draws.choice(place, 0, 1000, is_whole=True) for place in range(count))
        value = margin(made)
        if value < 0.0:
            return run
        search.judged(made, {"CHK-1": value})
    return most


def _distance(middles: list[float]) -> Margin:
    return lambda made: (
        sum(abs(share - middle) for share, middle in zip(_shares(made), middles, strict=True)) / len(middles)
        - 0.02
    )


def test_steps_find_what_drawing_hardly_finds() -> None:
    runs = sorted(
        _runs_to_failure(_distance([Random(seed + 99).random() for _ in range(4)]), seed, 300)
        for seed in range(20)
    )
    # The volume of failures is 16 * 0.08**4 / 24: one draw in 37,000.
    assert runs[-1] < 300, "a seed finds nothing"
    assert runs[10] < 80, f"runs to the first failure: {runs}"


def test_steps_follow_a_valley_across_the_coordinates() -> None:
    def margin(made: Choices) -> float:
        first, second = _shares(made)
        return abs(first + second - 1.0) + (first - 0.9) ** 2 - 1e-4

    runs = [_runs_to_failure(margin, seed, 300, count=2) for seed in range(10)]
    assert sum(run < 300 for run in runs) >= 8, runs


@given(st.integers(0, 1000), st.integers(1, 6))
def test_the_best_gets_better_and_stays_within_its_bounds(seed: int, count: int) -> None:
    source = Random(seed)
    margin = _distance([source.random() for _ in range(count)])
    start = _start(count, source)
    climb = Climb(start, margin(start), source)
    for _ in range(60):
        before, made = climb.margin, climb.next()
        assert all(choice.least <= choice.value <= choice.greatest for choice in made)
        value = margin(made)
        if value < before:
            climb.succeeded(made, value)
            assert (climb.best, climb.margin) == (made, value)
        else:
            climb.failed(value)
            assert climb.margin == before


def test_a_number_that_changes_nothing_is_not_moved_again() -> None:
    source, moved = Random(5), Counter[int]()
    start = _start(5, source)
    climb = Climb(start, 0.5, source)
    for _ in range(100):
        made = climb.next()
        places = [
            place for place, pair in enumerate(zip(climb.best, made, strict=True)) if pair[0] != pair[1]
        ]
        if len(places) == 1:
            moved[places[0]] += 1
        climb.failed(0.5)
    assert max(moved.values()) == 1, f"moves alone by place: {dict(moved)}"


def test_a_check_that_is_broken_or_hopeless_leaves_its_steps_to_others() -> None:
    search, stepped, source = Search(1), Counter[str](), Random(2)
    nearest = {"BRK-1": -0.5, "DEF-1": 0.01, "FAR-1": 0.3}
    for _ in range(60):
        made = search.choices()
        stepped[search.stepping or ""] += 1
        margins = {check: margin + 0.5 * source.random() for check, margin in nearest.items()}
        search.judged(made or _start(3, source), dict.fromkeys(nearest, 0.9) if made else margins)
    assert "BRK-1" not in stepped, "what fails already needs no steps"
    assert stepped["DEF-1"] > 0
    assert stepped["FAR-1"] > 0, f"the nearest check starves the others: {dict(stepped)}"


def test_steps_follow_what_is_unusually_near() -> None:
    search, stepped, source = Search(1), Counter[str](), Random(2)
    for number in range(40):
        made = search.choices()
        stepped[search.stepping or ""] += 1
        # One check's margin is always as small as can be, one is small as a rule, and one is so once.
        margins = {"SAM-1": 0.0, "LOW-1": 0.1 + 0.05 * source.random()}
        if number == 9:
            margins["ODD-1"] = 0.2
        search.judged(made or _start(3, source), dict.fromkeys(margins, 0.9) if made else margins)
    assert "SAM-1" not in stepped, "nothing moves that margin"
    assert stepped["ODD-1"] > stepped["LOW-1"], dict(stepped)


def test_steps_find_a_failure_at_ends_that_margins_lead_away_from() -> None:
    def margin(made: Choices) -> float:
        first, second, third = _shares(made)
        if third < 0.02 and first + second < 0.1:
            return -1.0
        return 0.1 + 0.1 * (first + second) + 0.1 * (1.0 - third)

    runs = [_runs_to_failure(margin, seed, 300, count=3) for seed in range(20)]
    # One draw in 10,000 fails.
    assert sum(run < 300 for run in runs) >= 18, runs


def test_a_step_that_shows_nothing_new_counts_as_none() -> None:
    search, source = Search(1), Random(2)
    for margin in (0.5, 0.4):
        assert search.choices() == ()
        search.judged(_start(3, source), {"CHK-1": margin})
    made = search.choices()
    assert made
    search.judged(made, None)
    assert search.choices() == (), "a draw comes after a step in vain"


@pytest.mark.parametrize("seed", [0, 1])
def test_the_seed_alone_decides(seed: int) -> None:
    def row() -> list[Choices]:
        search, source, rows = Search(seed), Random(9), []
        for _ in range(30):
            rows.append(search.choices())
            made = rows[-1] or _start(4, source)
            search.judged(made, {"CHK-1": _distance([0.1, 0.2, 0.3, 0.4])(made)})
        return rows

    assert row() == row()
