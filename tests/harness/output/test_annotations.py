"""Annotations for GitHub: what is an error there, and what a text may not do to the commands."""

from __future__ import annotations

from typing import Any

import pytest
from tests.harness.made import with_hash

from drivegate.output.result_reports import workflow_commands


def result(
    *checks: dict[str, Any],
    faults: tuple[dict[str, Any], ...] = (),
    fail_on: str = "required",
    specification: str = "mine",
) -> Any:
    document = {
        "candidate": {"name": "mine", "specification": specification},
        "checks": checks,
        "faults": faults,
        "baseline": None,
        "fail_on": fail_on,
    }
    return with_hash(document)


def check(
    verdict: str, level: str = "required", message: str = "as measured", name: str = "CNV-1"
) -> dict[str, Any]:
    return {
        "id": name,
        "verdict": verdict,
        "level": level,
        "message": message,
        "runs": 0,
        "counterexample": None,
    }


@pytest.mark.parametrize(
    ("verdict", "level", "fail_on", "shown"),
    [
        ("pass", "required", "required", None),
        ("not applicable", "required", "required", None),
        ("fail", "required", "required", "error"),
        ("inconclusive", "required", "required", "error"),
        ("waiver expired", "required", "required", "error"),
        ("waived", "required", "required", "notice"),
        ("contested", "required", "required", "warning"),
        ("not yet witnessed", "required", "required", "warning"),
        ("fail", "advisory", "required", "warning"),
        ("fail", "advisory", "advisory", "error"),
    ],
)
def test_what_fails_the_job_is_an_error(verdict: str, level: str, fail_on: str, shown: str | None) -> None:
    expected = [] if shown is None else [f"::{shown} title=mine CNV-1 {verdict}::as measured"]
    assert workflow_commands(result(check(verdict, level), fail_on=fail_on)) == expected


def test_no_text_ends_its_command_or_begins_another() -> None:
    lines = workflow_commands(result(check("fail", message="50 % off\n::warning::x, y: z")))
    assert len(lines) == 1
    assert lines[0].count("\n") == 0
    assert lines[0].startswith("::error title=mine CNV-1 fail::50 %25 off")


@pytest.mark.parametrize(
    ("specification", "file"),
    [
        ("candidate.toml", "candidate.toml"),
        ("firmware/mine.py:Mine", "firmware/mine.py"),
        ("a,b%.toml", "a%2Cb%25.toml"),
        ("/tmp/candidate.toml", ""),
        ("foc", ""),
        ("inner:pi:reference", ""),
    ],
)
def test_an_annotation_is_at_the_file_of_the_candidate(specification: str, file: str) -> None:
    (line,) = workflow_commands(result(check("fail"), specification=specification))
    assert line.startswith(f"::error file={file},title=mine " if file else "::error title=mine ")


def test_a_fault_is_an_error() -> None:
    fault = {
        "kind": "exception",
        "message": "ValueError: x",
        "phase": "step",
        "traceback": "",
        "scenario": None,
    }
    assert workflow_commands(result(faults=(fault,)))[0].startswith("::error title=mine exception")


def test_the_first_places_are_those_of_failures() -> None:
    open_ones = [check("inconclusive", name=f"TRP-{number}") for number in range(1, 17)]
    advisory = [check("inconclusive", "advisory", name=f"TRA-{number}") for number in range(1, 4)]
    lines = workflow_commands(result(*open_ones, *advisory, check("fail", name="STP-1")))
    assert lines[0].startswith("::error title=mine STP-1 fail::")
    assert lines[1].startswith("::error title=mine 16 checks inconclusive::TRP-1, TRP-2, ")
    assert lines[2] == "::warning title=mine 3 checks inconclusive::TRA-1, TRA-2, TRA-3; TRA-1: as measured"
    assert len(lines) == 3


def test_what_has_no_place_is_named_in_the_last_one() -> None:
    failing = [check("fail", name=f"STP-{number}") for number in range(1, 15)]
    faults = tuple(
        {"kind": "crash", "message": f"at {place}", "phase": "step", "traceback": "", "scenario": None}
        for place in range(5)
    )
    lines = workflow_commands(result(*failing, check("inconclusive", name="CNV-1"), faults=faults))
    assert len(lines) == 10
    assert lines[0].startswith("::error title=mine crash::at 0")
    assert lines[1].startswith("::error title=mine STP-1 fail::")
    assert lines[8].startswith("::error title=mine 11 more::STP-8 fail; ")
    assert lines[9].startswith("::error title=mine CNV-1 inconclusive::")
