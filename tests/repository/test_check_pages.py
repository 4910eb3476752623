"""Every check has a page in the documentation, whose facts come from the catalogue."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from drivegate.checks.check import Check
from drivegate.contracts.catalogue import all_checks
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate.contracts.duty.checks.catalogue import DUTY_CHECKS
from drivegate_lab.candidates.faults.catalogue import MUTATIONS
from drivegate_lab.selftest.subjects import FAULTS_OF

DOCS = Path(__file__).parents[2] / "docs"
SECTIONS = ["Judging", "Typical faults", "Counterexample"]


def test_pages_and_checks_match() -> None:
    pages = {page.stem for page in (DOCS / "checks").glob("*.md")}
    assert pages == set(all_checks())


@pytest.mark.parametrize("check", DUTY_CHECKS, ids=lambda check: check.id)
def test_a_page_states_of_a_check_of_duty_ratios(check: Check) -> None:
    text = (DOCS / "checks" / f"{check.id}.md").read_text(encoding="utf-8")
    assert f"<!-- inserted: check duty:{check.id} -->\n" in text
    assert [head for head in re.findall(r"^## (.+)$", text, re.MULTILINE) if head in SECTIONS] == SECTIONS


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.id)
def test_a_page_inserts_what_the_catalogue_knows_and_states_the_rest(check: Check) -> None:
    text = (DOCS / "checks" / f"{check.id}.md").read_text(encoding="utf-8")
    assert text.startswith(f"# {check.id}: ")
    assert f"<!-- inserted: check {check.id} -->\n" in text
    heads = [head for head in re.findall(r"^## (.+)$", text, re.MULTILINE) if head != "With duty ratios"]
    assert heads == SECTIONS
    assert check.requirement not in re.sub(r"<!-- inserted.*?<!-- end -->", "", text, flags=re.DOTALL), (
        "the requirement must be typed in one place"
    )
    inserted = "".join(re.findall(r"<!-- inserted.*?<!-- end -->", text, flags=re.DOTALL))
    named = {mutation.name for mutation in MUTATIONS.values() if mutation.check == check.id}
    assert named <= set(re.findall(r"`faulty:([a-z0-9-]+)`", inserted)), (
        "the self-test's faults must be inserted"
    )


def test_the_faulty_controllers_that_pages_name_exist() -> None:
    for page in DOCS.rglob("*.md"):
        named = set(re.findall(r"faulty:([a-z0-9-]+)", page.read_text(encoding="utf-8")))
        known = {*MUTATIONS, *FAULTS_OF["duty"]}
        assert named <= known, f"{page.name} names {named - known}, which do not exist"
