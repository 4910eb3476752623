"""What a fault kept from being judged, in words: named as such, with the fault as its reason."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from typing import Any

import pytest
from tests.harness.made import with_hash

from drivegate.output.continuous_integration import junit_xml, markdown
from drivegate.output.explanations import explanations, unjudged_in_words
from drivegate.output.result_reports import workflow_commands

CRASH = {"kind": "crash", "phase": "step", "message": "the process was killed", "traceback": ""}


def check(name: str, verdict: str, *, runs: int = 0, level: str = "required") -> dict[str, Any]:
    return {
        "id": name,
        "verdict": verdict,
        "level": level,
        "message": "as measured",
        "margin": None,
        "runs": runs,
        "counterexample": None,
    }


@pytest.fixture
def crashed() -> dict[str, Any]:
    """A result that a crash has ended: one check met so far, one without a run, one that only advises."""
    return {
        "candidate": {"name": "mine", "specification": "mine.py:Mine"},
        "verdict": "crash",
        "effort": "quick",
        "seed": 0,
        "runs": 3,
        "set_aside": 0,
        "corpus_runs": 0,
        "fail_on": "required",
        "checks": [
            check("ADV-1", "inconclusive", runs=3),
            check("CNV-1", "inconclusive"),
            check("CNV-2", "not applicable"),
            check("CPW-2", "inconclusive", level="advisory"),
        ],
        "faults": [CRASH, CRASH],
        "baseline": None,
        "timing": {"seconds": 1.0},
        "provenance": {"drivegate": "0.1.0"},
    }


def test_what_a_crash_kept_from_being_judged_is_listed(crashed: dict[str, Any]) -> None:
    assert unjudged_in_words(crashed) == "not judged: CNV-1, CPW-2; judged in part only: ADV-1"
    assert explanations(crashed) == {
        "ADV-1": "judged in part only, because of crash: the process was killed",
        "CNV-1": "not judged, because of crash: the process was killed",
        "CPW-2": "not judged, because of crash: the process was killed",
    }


def test_the_first_of_several_faults_stands_for_all(crashed: dict[str, Any]) -> None:
    crashed["faults"] += [CRASH | {"message": "died later"}, CRASH | {"message": "died at last"}]
    stated = "not judged, because of crash: the process was killed and 2 more faults"
    assert explanations(crashed)["CNV-1"] == stated


def test_a_check_that_ended_early_without_a_fault_is_explained_by_none(crashed: dict[str, Any]) -> None:
    crashed["faults"] = []
    assert unjudged_in_words(crashed) == ""
    assert explanations(crashed) == {}


def test_the_summary_lists_it_under_the_fault(crashed: dict[str, Any]) -> None:
    lines = markdown(crashed).splitlines()
    fault = lines.index("- crash in 2 runs: the process was killed")
    assert lines[fault + 1 : fault + 3] == ["", "not judged: CNV-1, CPW-2; judged in part only: ADV-1"]


def test_junit_gives_the_reason_and_skips_what_only_advises(crashed: dict[str, Any]) -> None:
    cases = {case.get("name"): case for case in ElementTree.fromstring(junit_xml(crashed)).iter("testcase")}
    expected = {
        "ADV-1": ("error", "judged in part only, because of crash: the process was killed; as measured"),
        "CNV-1": ("error", "not judged, because of crash: the process was killed; as measured"),
        "CNV-2": ("skipped", "as measured"),
        "CPW-2": ("skipped", "not judged, because of crash: the process was killed; as measured"),
    }
    assert {
        name: (case[0].tag, case[0].get("message")) for name, case in cases.items() if name in expected
    } == expected
    assert [line for line in workflow_commands(crashed) if "CNV-1" in line] == [
        "::error file=mine.py,title=mine 2 checks inconclusive::ADV-1, CNV-1; "
        "ADV-1: judged in part only, because of crash: the process was killed; as measured"
    ]


def test_what_failed_comes_before_what_was_not_judged(crashed: dict[str, Any]) -> None:
    crashed["checks"].append(check("STP-1", "fail") | {"requirement": "Settles.", "limit": "25 %"})
    cases = [
        case.get("name") for case in ElementTree.fromstring(junit_xml(with_hash(crashed))).iter("testcase")
    ]
    assert cases[:2] == ["fault 1", "STP-1"]
    rows = [line for line in markdown(crashed).splitlines() if line.startswith("| ")]
    assert rows[1].startswith("| STP-1 | required | fail |")
