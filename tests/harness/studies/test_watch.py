"""Checking again after changes: what failed comes first, and nothing is checked twice."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from drivegate.studies.check.watch import changes_around, version_of, watch
from drivegate_models.errors import InputError


def watched(versions: list[str], codes: list[int], *, during: int = 0) -> tuple[list[bool], int]:
    """Return which checks began with what failed, and the last exit code.

    `during` is the number of the changes that happen within the first check.
    """
    place, answers, begun = 0, iter(codes), []

    def check(begin_with_failed: bool) -> int:
        nonlocal place
        place += during if not begun else 0
        begun.append(begin_with_failed)
        return next(answers)

    def changes() -> Iterator[int]:
        nonlocal place
        while place + 1 < len(versions):
            place += 1
            yield place

    code = watch(check, changes(), lambda: versions[place])
    return begun, code


def test_after_a_pass_the_whole_check_follows_each_change():
    assert watched(["a", "b", "c"], [0, 0, 0]) == ([False, False, False], 0)


def test_after_a_failure_what_failed_comes_first_and_the_rest_once_that_passes():
    assert watched(["a", "b", "c"], [1, 1, 0, 0]) == ([False, True, True, False], 0)


def test_a_change_that_is_none_of_the_sources_checks_nothing():
    assert watched(["a", "a", "a"], [1]) == ([False], 1)


def test_a_change_within_a_check_is_not_missed():
    assert watched(["a", "b"], [0, 0], during=1) == ([False, False], 0)


def test_a_refused_candidate_is_checked_whole_once_it_is_mended():
    assert watched(["a", "broken", "c"], [0, 2, 0]) == ([False, False, False], 0)


CONTROLLER = "class C:\n    def reset(self, n): pass\n    def step(self, s): pass\n"


@pytest.fixture
def candidate(tmp_path: Path) -> Path:
    file = tmp_path / "controller.py"
    file.write_text(CONTROLLER, encoding="utf-8")
    return file


def test_the_version_follows_the_sources(candidate: Path) -> None:
    before = version_of(f"{candidate}:C")
    candidate.write_text(CONTROLLER + "# another\n", encoding="utf-8")
    assert version_of(f"{candidate}:C") != before
    candidate.unlink()
    assert "does not exist" in version_of(f"{candidate}:C")


def test_changes_are_those_of_the_sources_folder_without_the_reports(candidate: Path) -> None:
    changes: Iterator[object] = changes_around(f"{candidate}:C", candidate.parent / "drivegate-report")

    def change() -> None:
        (candidate.parent / "drivegate-report").mkdir()
        (candidate.parent / "drivegate-report" / "result.json").touch()
        candidate.write_text(CONTROLLER + "# changed\n", encoding="utf-8")

    timer = threading.Timer(0.3, change)
    timer.start()
    names = {Path(path).name for _, path in next(changes)}  # type: ignore[attr-defined]
    timer.join()
    assert names == {"controller.py"}


def test_a_missing_package_is_named(candidate: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "watchfiles", None)
    with pytest.raises(InputError, match=r"drivegate\[watch\]"):
        changes_around(f"{candidate}:C", candidate.parent)
