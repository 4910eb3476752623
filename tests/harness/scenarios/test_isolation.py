"""Draws follow from the seed alone."""

import importlib.util
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import Phase, configuration, given, seed, settings
from hypothesis import strategies as st

from drivegate.scenarios.isolation import from_the_seed_alone

NUMBERS = tuple(range(4_000_001, 4_000_400))


@pytest.fixture
def candidate_with_numbers(tmp_path: Path) -> Iterator[None]:
    """A module outside of site-packages that is full of numbers, as a candidate's may be."""
    file = tmp_path.parent / "candidate_with_numbers.py"
    file.write_text(f"NUMBERS = {NUMBERS}\n")
    spec = importlib.util.spec_from_file_location("candidate_with_numbers", file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    sys.modules["candidate_with_numbers"] = module
    yield
    del sys.modules["candidate_with_numbers"]
    file.unlink()


def drawn() -> list[int]:
    numbers: list[int] = []

    @seed(11)
    @settings(max_examples=400, database=None, phases=[Phase.generate])
    @given(st.integers(0, 2**40))
    def collect(number: int) -> None:
        numbers.append(number)

    collect()
    return numbers


@pytest.mark.usefixtures("candidate_with_numbers")
def test_numbers_in_a_candidate_s_source_are_not_drawn() -> None:
    assert set(drawn()) & set(NUMBERS), "Hypothesis takes numbers from sources no more; the isolation may go"
    with from_the_seed_alone():
        assert not set(drawn()) & set(NUMBERS)


def test_the_same_seed_draws_the_same_whatever_is_imported(request: pytest.FixtureRequest) -> None:
    with from_the_seed_alone():
        before = drawn()
        request.getfixturevalue("candidate_with_numbers")
        assert drawn() == before


def test_notes_of_hypothesis_leave_the_working_folder_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with from_the_seed_alone():
        drawn()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("named", [True, False])
def test_hypothesis_keeps_its_later_notes_where_it_did_before(tmp_path: Path, named: bool) -> None:
    def notes() -> Path:
        return configuration.storage_directory("examples", intent_to_write=False).path

    if named:
        configuration.set_hypothesis_home_dir(tmp_path)
    before = notes()
    with from_the_seed_alone():
        assert notes() != before
    assert notes() == before
    configuration.set_hypothesis_home_dir(None)
