"""What a check makes of the shares that are reached of a candidate's code."""

from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import pytest

from drivegate.candidates.candidate import Instrumented
from drivegate.candidates.reached_code import Line, SourceFile
from drivegate.candidates.resolution import resolve_candidate
from drivegate.results.document import ResultDocument
from drivegate.studies.check.inspection import (
    BELOW,
    Inspection,
    inspected,
    read_inspection,
    read_shares,
    require_branches,
    with_coverage,
    with_findings,
)
from drivegate_models.errors import InputError

FILE = SourceFile("mine.c", ("a;", "if (b)", "c;"), (Line(1, 7), Line(2, 7, (7, 0)), Line(3, 0)))


@pytest.mark.parametrize("text", ["", "many", "101", "-1", "90,", "90,95,99"])
def test_shares_that_are_none_are_refused(text: str) -> None:
    with pytest.raises(InputError, match="--coverage-at-least is"):
        read_shares(text)


def test_shares_are_those_of_lines_and_of_branches() -> None:
    assert read_shares("100") == (100.0, 0.0)
    assert read_shares("99.5,95") == (99.5, 95.0)
    assert read_inspection(False, "80", None) == Inspection(True, (80.0, 0.0))


@pytest.mark.parametrize(
    ("required", "verdict", "exit_code"),
    [
        (None, "pass", 0),
        ((66.0, 50.0), "pass", 0),
        ((67.0, 0.0), BELOW, 1),
        ((0.0, 51.0), BELOW, 1),
    ],
)
def test_too_little_that_is_reached_fails_a_candidate(
    required: tuple[float, float] | None, verdict: str, exit_code: int
) -> None:
    passed = ResultDocument.model_construct(verdict="pass", exit_code=0)
    result = with_coverage(passed, [FILE], required)
    assert (result.verdict, result.exit_code) == (verdict, exit_code)
    section = result.code_coverage
    assert section is not None
    assert section.message.startswith("the runs reached 2 of 3 lines (66.6 %) and 1 of 2 branches (50 %)")
    assert ("below" in section.message) is (exit_code == 1)
    assert (section.files[0].unreached_lines, section.files[0].unreached_branches) == ((3,), ((2, 2),))


def test_a_failure_stays_one() -> None:
    failed = ResultDocument.model_construct(verdict="fail", exit_code=1)
    assert with_coverage(failed, [FILE], (100.0, 0.0)).verdict == "fail"


def test_coverage_and_sanitizers_do_not_go_together() -> None:
    both = Inspection(coverage=True, sanitizers=("address",))
    with pytest.raises(InputError, match="check twice"), inspected(resolve_candidate("foc"), both):
        pass


def test_unknown_sanitizers_are_refused() -> None:
    with pytest.raises(InputError, match="'adress', the nearest known one is 'address'"):
        read_inspection(False, None, "undefined,adress")


def test_branches_cannot_be_required_where_lines_alone_are_counted(tmp_path: Path) -> None:
    looking = Instrumented("coverage", tmp_path, counts_branches=False)
    lines_only = replace(resolve_candidate("foc"), instrumented=looking)
    require_branches(lines_only, Inspection(coverage=True, at_least=(100.0, 0.0)))
    with pytest.raises(
        InputError, match=r"95 % of branches, but only lines .* write --coverage-at-least 100$"
    ):
        require_branches(lines_only, Inspection(coverage=True, at_least=(100.0, 95.0)))
    passed = ResultDocument.model_construct(verdict="pass", exit_code=0)
    section = with_coverage(passed, [FILE], None, counts_branches=False).code_coverage
    assert section is not None
    assert section.message == "the runs reached 2 of 3 lines (66.6 %); branches are not counted"


@pytest.mark.parametrize("is_faulty", [False, True])
def test_faults_count_for_more_than_that_nothing_was_counted(tmp_path: Path, is_faulty: bool) -> None:
    (tmp_path / "mine.py").write_text("class Mine: pass\n", encoding="utf-8")
    counted = tmp_path / "counted"
    counted.mkdir()
    candidate = replace(
        resolve_candidate(f"{tmp_path / 'mine.py'}:Mine"), instrumented=Instrumented("coverage", counted)
    )
    result = ResultDocument.model_construct(verdict="crash", exit_code=int(is_faulty))
    expected = nullcontext() if is_faulty else pytest.raises(InputError, match=r"no line of .* was counted")
    with expected:
        assert with_findings(result, candidate, Inspection(coverage=True), tmp_path) is result
