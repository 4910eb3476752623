"""The summary of a result: what failed comes first, each number with the scenario that it was measured in."""

from __future__ import annotations

from typing import Any

import pytest

from drivegate.output.continuous_integration import markdown

WORST = "90.29 A; fails in 2 of 9 runs: hard-run, plain-run"


def failed(found: dict[str, Any] | None) -> dict[str, Any]:
    check = {
        "id": "OVC-1",
        "verdict": "fail",
        "level": "required",
        "message": WORST,
        "margin": -0.5,
        "runs": 9,
        "scenario": {"name": "hard-run"},
        "counterexample": {"name": "plain-run"},
        "found": found,
        "recording": None,
    }
    return {
        "candidate": {"name": "mine", "specification": "mine.py:Mine"},
        "verdict": "fail",
        "effort": "quick",
        "seed": 0,
        "runs": 9,
        "set_aside": 0,
        "corpus_runs": 0,
        "fail_on": "required",
        "checks": [check],
        "faults": [],
        "baseline": None,
        "traces": [],
        "timing": {"seconds": 1.0},
        "provenance": {"drivegate": "0.1.0"},
    }


FILE = "[counterexamples/OVC-1.json](counterexamples/OVC-1.json)"


@pytest.mark.parametrize(
    ("found", "lines"),
    [
        (
            {"margin": -0.1, "measured": "66 A", "size": 2, "runs": 7},
            [
                f"- **OVC-1** fail (required), in plain-run: 66 A; {FILE}",
                f"  Worst run: {WORST}",
            ],
        ),
        (None, [f"- **OVC-1** fail (required), in plain-run: {WORST}; {FILE}"]),
    ],
    ids=["shrunk", "unchanged"],
)
def test_a_counterexample_is_listed_with_its_own_number(
    found: dict[str, Any] | None, lines: list[str]
) -> None:
    listed = markdown(failed(found)).splitlines()
    first = listed.index("## What failed") + 2
    assert listed[first : first + len(lines)] == lines
    assert listed[first + len(lines)] == ""
