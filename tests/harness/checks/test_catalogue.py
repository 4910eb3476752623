"""The catalogue against the table of requirements, and when a check does not apply."""

import re

import pytest

from drivegate.candidates.declaration import Declaration, FlowchartProfile
from drivegate.contracts.catalogue import contract_named, on_drive
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate_cases.drive.drive_document import load_drive

PAPER = load_drive("paper-5-phase")
LEVELS = {
    "PWR-1": "required",
    "PWR-2": "required",
    "NEU-1": "required",
    "ADV-1": "required",
    "ADV-2": "required",
    "CMD-1": "required",
    "RIP-1": "required",
    "RIP-2": "advisory",
    "RIP-3": "advisory",
    "TRQ-1": "advisory",
    "CNV-1": "required",
    "CNV-2": "required",
    "CNV-3": "required",
    "CPW-1": "required",
    "CPW-2": "advisory",
    "CUR-1": "advisory",
    "ROB-1": "required",
    "ROB-2": "required",
    "ROB-3": "required",
    "DET-1": "required",
    "TIM-1": "advisory",
    "FLO-1": "required",
}


def test_every_check_is_listed_once_with_its_level():
    assert {check.id: check.level for check in CHECKS} == LEVELS
    assert len(CHECKS) == len(LEVELS)


def test_only_the_plants_own_law_is_no_matter_of_the_candidate():
    assert [check.id for check in CHECKS if check.subject == "plant"] == ["PWR-1", "NEU-1"]


def test_only_the_check_of_time_depends_on_the_machine():
    assert [check.id for check in CHECKS if check.volatile] == ["TIM-1"]


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.id)
def test_every_check_states_what_it_is_about(check):
    for attribute in ("requirement", "source", "limit", "scenarios", "formula", "why"):
        assert getattr(check, attribute), f"{check.id} has no {attribute}"
    assert check.requirement.endswith(".")
    assert check.why.endswith(".")


def test_a_candidate_that_declares_nothing_is_spared_the_flowchart_alone():
    reasons = {check.id: check.reason_not_applicable(Declaration(), PAPER) for check in CHECKS}
    inapplicable = {identifier: reason for identifier, reason in reasons.items() if reason is not None}
    assert inapplicable == {
        "FLO-1": "the candidate does not declare the profile 'flowchart'",
        "NEU-1": "the phases of this drive are decoupled: each has its own return to the tap of the supply",
    }


def test_a_star_has_a_neutral_to_judge():
    reasons = {
        check.id: check.reason_not_applicable(Declaration(), load_drive("star-3-phase")) for check in CHECKS
    }
    assert [identifier for identifier, reason in reasons.items() if reason is not None] == ["FLO-1"]


def test_a_peak_is_judged_only_where_every_half_window_is_regulated():
    drive = load_drive("star-3-phase").replaced(regulation="upper-only")
    reasons = {check.id: check.reason_not_applicable(Declaration(), drive) for check in CHECKS}
    assert reasons["CUR-1"] is not None
    assert 'regulation = "upper-only"' in reasons["CUR-1"]


def test_the_profile_flowchart_asks_for_its_check():
    declaration = Declaration(FlowchartProfile(0.5, 0.0, 0.001, 0.02, 0.1))
    assert [check.id for check in CHECKS if check.reason_not_applicable(declaration, PAPER) is not None] == [
        "NEU-1"
    ]


@pytest.mark.parametrize(
    ("speeds", "spared"),
    [
        ((0.0, 499.0), {"RIP-1", "RIP-2", "RIP-3", "TRQ-1", "CNV-1", "CNV-2", "CNV-3", "CPW-1", "CPW-2"}),
        ((500.0, 1500.0), {"ADV-1", "CPW-2"}),
        ((499.0, 549.0), {"RIP-1", "RIP-2", "CPW-1", "CPW-2"}),
        ((600.0, 1499.0), {"ADV-1", "RIP-1", "CPW-2"}),
        ((1501.0, 3000.0), {"ADV-1", "RIP-1", "RIP-2", "CPW-1"}),
    ],
)
def test_a_candidate_is_spared_checks_at_speeds_that_it_is_not_made_for(speeds, spared):
    declaration = Declaration(speed_range_rpm=speeds)
    reasons = {
        check.id: check.reason_not_applicable(declaration, PAPER)
        for check in CHECKS
        if check.id not in ("FLO-1", "NEU-1")
    }
    inapplicable = {identifier: reason for identifier, reason in reasons.items() if reason is not None}
    robust = {"ROB-1", "ROB-2", "ROB-3"} if "CNV-1" in spared else set()
    assert set(inapplicable) == spared | robust
    for reason in inapplicable.values():
        assert f"declares a speed range of {speeds[0]:g} to {speeds[1]:g} rpm" in reason, reason


def test_the_reason_names_the_speeds_that_the_check_is_about():
    reasons = {
        check.id: check.reason_not_applicable(Declaration(speed_range_rpm=(0.0, 400.0)), PAPER)
        for check in CHECKS
    }
    assert reasons["RIP-1"] == (
        "the candidate declares a speed range of 0 to 400 rpm, which contains none of 1500 rpm"
    )
    assert reasons["CPW-1"] == (
        "the candidate declares a speed range of 0 to 400 rpm, "
        "which contains none of the speeds from 550 to 1500 rpm"
    )
    assert reasons["CNV-1"] == (
        "the candidate declares a speed range of 0 to 400 rpm, which contains none of the speeds above 500 rpm"
    )


def test_a_star_that_states_no_ripple_is_not_judged_by_it():
    drive = load_drive("star-3-phase").replaced(ripple_percent=None, closed_loop_ripple_percent=None)
    reasons = {check.id: check.reason_not_applicable(Declaration(), drive) for check in CHECKS}
    spared = {identifier for identifier, reason in reasons.items() if reason is not None}
    assert spared == {"FLO-1", "RIP-1", "RIP-2", "RIP-3"}
    assert "states no requirements.ripple_percent" in reasons["RIP-1"]
    assert all("inf" not in text for check in CHECKS for text in (on_drive(check, drive).limit,))


VAGUE = re.compile(
    r"\b(hardly|nearly|almost|soon|quickly|much|far|near|enough|roughly|about|too high|too low|in time|well|good|small|"
    r"large)\b"
)


@pytest.mark.parametrize("contract", ["current", "duty"])
def test_a_requirement_can_be_tested(contract):
    """A sentence that a reviewer cannot judge by a number is no requirement."""
    requirements = {check.id: check.requirement for check in contract_named(contract).checks}
    vague = {name: VAGUE.findall(text.replace("for good", "")) for name, text in requirements.items()}
    assert {name: words for name, words in vague.items() if words} == {}


def test_requirements_of_duty_ratios_state_their_limits():
    drive = load_drive("pm-ac-interior")
    for check in contract_named("duty").checks:
        text = on_drive(check, drive).requirement
        if check.subject == "candidate" and check.id != "DET-1":
            assert re.search(r"\d|peak limit", text), f"{check.id} states no number: {text}"
