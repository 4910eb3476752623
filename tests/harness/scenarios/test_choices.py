"""Even draws from the strategies of scenarios, and the same scenario again with one choice changed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from drivegate.candidates.declaration import NOTHING_DECLARED
from drivegate.contracts.catalogue import contract_of
from drivegate.scenarios.choices import STRATA, Choice, Choices, ChoiceSource, Enough, EvenDraws, draw_from
from drivegate_cases.drive.drive_document import load_drive


def _drawn(
    strategy: st.SearchStrategy[object],
    count: int,
    seed: int = 0,
    given_choices: Callable[[], Choices] = tuple,
) -> list[tuple[object, Choices]]:
    """Draw some values, each with its choices."""
    source = ChoiceSource(seed, given_choices)
    drawn: list[tuple[object, Choices]] = []

    @given(strategy)
    def explore(value: object) -> None:
        if source.is_asked:
            drawn.append((value, source.made))
        if len(drawn) == count:
            raise Enough

    with pytest.raises(Enough):
        draw_from(source, explore, 10 * count + 10)
    return drawn


@pytest.mark.parametrize(("least", "greatest", "is_whole"), [(-40, 279, True), (0.25, 1.25, False)])
def test_no_part_of_a_range_is_drawn_from_twice_before_all_others(
    least: float, greatest: float, is_whole: bool
) -> None:
    draws = EvenDraws(3)
    values = [draws.choice(0, least, greatest, is_whole=is_whole).value for _ in range(3 * STRATA)]
    assert all(least <= value <= greatest for value in values)
    size = (greatest - least + is_whole) / STRATA
    for first in range(0, len(values), STRATA):
        parts = {int((value - least) / size) for value in values[first : first + STRATA]}
        assert parts == set(range(STRATA)), f"draws {first} to {first + STRATA} leave parts out"


def test_alternatives_take_turns() -> None:
    values = [value for value, _ in _drawn(st.sampled_from("abcde"), 20)]
    assert Counter(values) == dict.fromkeys("abcde", 4)
    assert len({tuple(values[place : place + 5]) for place in range(0, 20, 5)}) > 1, (
        "always in the same order"
    )


def test_a_share_of_the_draws_goes_to_the_ends_of_ranges() -> None:
    values = [value for value, _ in _drawn(st.tuples(*[st.integers(0, 1000)] * 3), 300)]
    corners = sum(all(part in (0, 1000) for part in value) for value in values)  # type: ignore[attr-defined]
    inside = sum(all(0 < part < 1000 for part in value) for value in values)  # type: ignore[attr-defined]
    assert 2 <= corners <= 20, "one in six draws is at the ends, of which one in eight is at all three"
    assert inside > 200


def test_given_choices_make_the_same_scenario_again_and_a_changed_one_changes_it() -> None:
    drive = load_drive("pm-ac-interior")
    families = contract_of(drive).drawn_scenarios(drive, NOTHING_DECLARED, 0)
    (scenario, made), (other, _) = _drawn(families, 2)
    assert scenario != other
    (again, choices), *_ = _drawn(families, 1, seed=7, given_choices=lambda: made)
    assert (again, choices) == (scenario, made)
    place, choice = next((place, choice) for place, choice in enumerate(made) if choice.is_number)
    moved = choice.at(choice.greatest if choice.value < choice.greatest else choice.least)
    changed = (*made[:place], moved, *made[place + 1 :])
    (different, _), *_ = _drawn(families, 1, seed=7, given_choices=lambda: changed)
    assert different != scenario


def test_choices_of_another_row_are_drawn_anew() -> None:
    row = (Choice(1, 0, 1, is_whole=True), Choice(50, 0, 99, is_whole=True))
    either = st.one_of(st.integers(0, 9), st.integers(0, 99))
    assert _drawn(either, 1, given_choices=lambda: row)[0][0] == 50
    first = (Choice(0, 0, 1, is_whole=True), Choice(50, 0, 99, is_whole=True))
    values = {value for value, _ in _drawn(either, 30, given_choices=lambda: first)}
    assert values == set(range(10)), "the number of the other alternative is no number of this one"


@pytest.mark.parametrize("name", ["paper-5-phase", "pm-ac-interior"])
def test_the_seed_alone_decides_what_every_group_of_families_draws(name: str) -> None:
    drive = load_drive(name)
    for group in range(8):
        families = contract_of(drive).drawn_scenarios(drive, NOTHING_DECLARED, group)
        first, again, other = (_drawn(families, 6, seed) for seed in (group, group, group + 8))
        assert first == again
        assert first != other


def test_speeds_are_drawn_evenly() -> None:
    drive = load_drive("pm-ac-interior")
    families = contract_of(drive).drawn_scenarios(drive, NOTHING_DECLARED, 5)
    speeds = [abs(run.speed_rpm[0][1]) for run, _ in _drawn(families, 200)]  # type: ignore[attr-defined]
    middle = 0.5 * (min(speeds) + max(speeds))
    share = sum(speed < middle for speed in speeds) / len(speeds)
    assert 0.35 < share < 0.65, f"{share:.0%} of the speeds are in the lower half"


def test_what_ends_the_drawing_is_not_run_again() -> None:
    runs: list[object] = []

    def endless() -> Iterator[None]:
        while True:
            runs.append(None)
            yield None

    calls = endless()

    @given(st.integers(0, 5))
    def explore(_: int) -> None:
        next(calls)
        raise Enough

    with pytest.raises(Enough):
        settings(database=None, phases=(Phase.generate, Phase.shrink))(explore)()
    assert len(runs) == 1


def test_draws_do_not_depend_on_what_is_given_between_them() -> None:
    numbers = st.tuples(st.integers(0, 99), st.floats(0.0, 1.0), st.sampled_from("abcde"))
    given_once = (Choice(7.0, 0, 99, is_whole=True),)
    turns = iter([(), given_once, given_once] * 20)
    mixed = _drawn(numbers, 60, given_choices=lambda: next(turns, ()))
    whole, alone = (
        [value for value, made in drawn if made[0].value != 7.0] for drawn in (mixed, _drawn(numbers, 20))
    )
    assert len(whole) >= 19
    assert whole[:19] == alone[:19]
