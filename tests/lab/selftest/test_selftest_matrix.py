"""What the self-test makes of catches, misses and accusations."""

import io
from dataclasses import replace
from typing import Any

import pytest
from tests.harness.made import made_outcome, made_result

from drivegate.candidates.resolution import resolve_candidate
from drivegate.output.console import console_for
from drivegate.results.document import CheckSection, ResultDocument
from drivegate_lab.selftest.display import show_matrix
from drivegate_lab.selftest.matrix import DesignRow, FaultRow, LeastMargin, Matrix, detection_by_kind
from drivegate_lab.selftest.run import judged_design
from drivegate_lab.selftest.subjects import CorrectDesign, correct_designs
from drivegate_lab.selftest.trial import Catch
from drivegate_models.errors import HarnessFault

CAUGHT = FaultRow(
    name="slips",
    kind="Search",
    sentence="Slips.",
    check="CNV-2",
    catches={0: Catch(3, "near", "far off", 10, ("700 rpm",)), 1: Catch(7, "farther", "far off", 8, ())},
    failing=("CNV-1", "CNV-2"),
    runs=9,
)
MISSED = FaultRow(
    "hides", "Filters", "Hides.", "ADV-1", {0: Catch(1, "x", "1°", 4, ()), 1: None}, ("ADV-1", "CMD-1"), 40
)
ACQUITTED = DesignRow("reference", 0, "pass", {}, acquitted=True)
ACCUSED = DesignRow("design:other", 0, "fail", {"CNV-1": "moves by 3°"}, acquitted=False)


def matrix(*rows: FaultRow | DesignRow) -> Matrix:
    faults = tuple(row for row in rows if isinstance(row, FaultRow))
    designs = tuple(row for row in rows if isinstance(row, DesignRow))
    return Matrix(("ADV-1", "CMD-1", "CNV-1", "CNV-2"), faults, designs)


def test_all_caught_and_none_accused_passes() -> None:
    whole = matrix(CAUGHT, ACQUITTED)
    assert (whole.passed, whole.problems(), whole.document()["exit_code"]) == (True, [], 0)


def test_a_miss_with_one_seed_is_a_miss() -> None:
    whole = matrix(CAUGHT, MISSED)
    assert not whole.passed
    assert whole.problems() == [
        "ADV-1 misses the fault 'hides' with seed 1 in 40 runs: it fails CMD-1 instead"
    ]
    document = whole.document()
    assert document["exit_code"] == 1
    assert document["faults"][1]["caught"] is False
    assert document["faults"][1]["runs_to_first"] is None


def test_a_fault_that_does_nothing_on_the_drive_is_neither_caught_nor_missed() -> None:
    idle = replace(MISSED, catches={}, failing=(), runs=0, idle_because="16 bits hold that")
    whole = matrix(CAUGHT, idle)
    assert (whole.passed, whole.problems()) == (True, [])
    assert [(row.faults, row.caught) for row in detection_by_kind((CAUGHT, idle))] == [(1, 1), (0, 0), (1, 1)]
    document = whole.document()["faults"][1]
    assert (document["caught"], document["does_not_apply"]) == (False, "16 bits hold that")
    stream = io.StringIO()
    show_matrix(console_for(stream), whole)
    assert "hides does not apply: 16 bits hold that" in stream.getvalue()
    assert "1 of 1 faults caught" in stream.getvalue()


def test_a_failure_that_the_base_shares_is_reported_as_such() -> None:
    shared = replace(MISSED, failing=(), unconvincing=2)
    assert matrix(shared).problems() == [
        "ADV-1 misses the fault 'hides' with seed 1 in 40 runs: no other check fails, and ADV-1 only where the "
        "controller without the fault fails it too"
    ]


def test_faults_are_counted_by_kind_and_altogether() -> None:
    quick = replace(
        CAUGHT, name="slides", catches={0: Catch(1, "x", "far off", 3, ("700 rpm", "mcs96 sensors"))}
    )
    search, filters, every = detection_by_kind((CAUGHT, quick, MISSED))
    assert (search.kind, search.faults, search.caught) == ("Search", 2, 2)
    assert (search.runs_median, search.runs_greatest) == (4.0, 7), "of each fault the slowest seed counts"
    assert (search.facts_median, search.facts_greatest) == (1.0, 2)
    assert (filters.faults, filters.caught, filters.runs_median, filters.facts_greatest) == (1, 0, None, None)
    assert (every.kind, every.faults, every.caught) == ("all", 3, 2)


def test_a_correct_design_near_a_limit_is_remarked_unless_it_is_near_by_design() -> None:
    least = LeastMargin("CNV-1", 0.06, "Σ|i| varies by 0.47 %")
    ordinary, near = (replace(ACQUITTED, near=near, least=least) for near in (False, True))
    whole = matrix(ordinary, near, replace(ACQUITTED, least=replace(least, margin=0.1)))
    assert whole.passed, "what is only near a limit is no problem"
    assert whole.remarks() == [
        "the correct design 'reference' meets CNV-1 by 0.06 alone with seed 0: Σ|i| varies by 0.47 %"
    ]


def test_the_accused_are_counted_apart_from_those_near_by_design() -> None:
    least = LeastMargin("CNV-1", 0.2, "")
    near = replace(ACQUITTED, name="near:one", near=True, least=replace(least, margin=0.03))
    again = replace(ACCUSED, seed=1, least=replace(least, margin=-3.0))
    ordinary, nearer = matrix(replace(ACQUITTED, least=least), ACCUSED, again, near).innocents()
    assert (ordinary.designs, ordinary.accused, ordinary.least) == (2, 1, again.least), (
        "each design counts once"
    )
    assert (nearer.designs, nearer.accused, nearer.least) == (1, 0, near.least)


def test_the_least_margin_leaves_out_what_is_met_at_the_end_of_a_range() -> None:
    ends = outcome("CMD-1", "pass", margin=0.0)
    advice = outcome("RIP-3", "fail", "advisory", margin=-0.2)
    judged = outcome("CNV-1", "pass", margin=0.4, measured="1 rpm")
    row = judged_design(CorrectDesign("reference"), result("pass", 0, ends, advice, judged))
    assert row.least == LeastMargin("CNV-1", 0.4, "1 rpm")


def test_a_correct_design_accused_is_a_problem() -> None:
    assert matrix(CAUGHT, ACQUITTED, ACCUSED).problems() == [
        "the correct design 'design:other' is accused with seed 0: fail; CNV-1: moves by 3°"
    ]


def test_the_document_states_the_slowest_catch() -> None:
    fault = matrix(CAUGHT).document()["faults"][0]
    assert fault["named_check"] == "CNV-2"
    assert (fault["runs_to_first"], fault["size"], fault["also_failing"]) == (7, 8, ["CNV-1"])
    assert fault["facts"] == [], "the slowest catch is of the plain run"
    assert [seed["seed"] for seed in fault["seeds"]] == [0, 1]


def outcome(check: str, verdict: str, level: str = "required", **changes: Any) -> CheckSection:
    usual = {"margin": -1.0, "message": f"{check} {verdict}"}
    return made_outcome(check, verdict, level=level, **usual | changes)


def result(verdict: str, code: int, *checks: CheckSection) -> ResultDocument:
    return made_result(resolve_candidate("reference"), verdict=verdict, exit_code=code, seed=4, checks=checks)


@pytest.mark.parametrize(
    ("design", "verdict", "acquitted"),
    [
        (CorrectDesign("reference"), "fail", False),
        (CorrectDesign("reference", frozenset({"FLO-1"})), "pass", True),
        (CorrectDesign("reference", frozenset({"CNV-1"})), "fail", False),
    ],
)
def test_a_design_is_judged_by_the_checks_that_it_must_pass(
    design: CorrectDesign, verdict: str, acquitted: bool
) -> None:
    checked = result("fail", 1, outcome("CNV-1", "fail"), outcome("FLO-1", "pass"))
    row = judged_design(design, checked)
    assert (row.verdict, row.acquitted, row.seed) == (verdict, acquitted, 4)
    assert bool(row.accused_by) is not acquitted


def test_a_contested_failure_of_a_correct_design_is_a_fault_of_the_checks() -> None:
    row = judged_design(CorrectDesign("reference"), result("contested", 0, outcome("CNV-1", "contested")))
    assert not row.acquitted
    assert set(row.accused_by) == {"CNV-1"}


def test_a_check_that_does_not_come_to_a_pass_acquits_nobody() -> None:
    design = CorrectDesign("reference", frozenset({"FLO-1"}))
    row = judged_design(design, result("pass", 0, outcome("FLO-1", "not applicable")))
    assert not row.acquitted


def test_an_advisory_failure_does_not_accuse() -> None:
    row = judged_design(CorrectDesign("reference"), result("pass", 0, outcome("RIP-2", "fail", "advisory")))
    assert row.acquitted
    assert (row.accused_by, row.advised_by) == ({}, ("RIP-2",))


def test_a_plant_that_fails_says_nothing_of_a_design() -> None:
    broken = outcome("PWR-1", "fail", subject="plant")
    with pytest.raises(HarnessFault, match=r"the plant failed while 'reference' .* seed 4: PWR-1"):
        judged_design(CorrectDesign("reference"), result("harness fault", 3, broken))


def test_every_correct_design_is_a_candidate() -> None:
    names = [resolve_candidate(design.candidate).name for design in correct_designs()]
    assert names[0] == "reference"
    assert len(set(names)) == len(names)


def test_the_console_states_facts_kinds_and_least_margins() -> None:
    least = LeastMargin("CNV-1", 0.04, "speed error 4.8 rpm")
    near = replace(ACQUITTED, name="near:one", near=True, least=least)
    ordinary = replace(ACQUITTED, least=least)
    stream = io.StringIO()
    slow = replace(CAUGHT, catches={0: Catch(7, "farther", "far off", 8, ("700 rpm", "mcs96 sensors"))})
    show_matrix(console_for(stream), matrix(slow, near, ordinary))
    shown = stream.getvalue()
    for words in (
        "700 rpm, mcs96 sensors",
        "1 of 1",
        "CNV-1 +0.040, near by design",
        "0 of 1",
        "by 0.04 alone",
    ):
        assert words in shown, f"{words} is not in\n{shown}"
