"""Every fact of the paper is held by something that really exists."""

from __future__ import annotations

import ast
import re
from importlib.util import find_spec
from pathlib import Path

import pytest

from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate_cases.publication import Fact, facts, findings

ROOT = Path(__file__).parents[3]


def functions_of(file: Path) -> set[str]:
    tree = ast.parse(file.read_text(encoding="utf-8"))
    return {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


def test_every_fact_is_covered() -> None:
    covers = {fact.id: fact.covered_by for fact in facts()}
    missing = [name for name, by in covers.items() if not (by.checks or by.properties or by.figures)]
    assert missing == [], f"no check, property or figure covers {missing}"


@pytest.mark.parametrize("fact", facts(), ids=lambda fact: fact.id)
def test_what_covers_a_fact_exists(fact: Fact) -> None:
    assert set(fact.covered_by.checks) <= {check.id for check in CHECKS}
    for name in fact.covered_by.properties:
        file, _, test = name.partition("::")
        assert (ROOT / file).is_file(), f"{fact.id} names {file}, which does not exist"
        assert test in functions_of(ROOT / file), f"{fact.id} names {test}, which is not in {file}"
    for figure in fact.covered_by.figures:
        module = find_spec(f"drivegate_lab.paper.figures.{figure}")
        assert module is not None, f"{fact.id} names the figure {figure}, which does not exist"


@pytest.mark.parametrize("fact", facts(), ids=lambda fact: fact.id)
def test_a_fact_names_exactly_the_checks_whose_source_it_is(fact: Fact) -> None:
    resting = {check.id for check in CHECKS if fact.id in re.findall(r"P\d+", check.source)}
    assert set(fact.covered_by.checks) == resting


def test_every_check_names_facts_that_exist_or_the_contract_or_a_law() -> None:
    known = {fact.id for fact in facts()}
    for check in CHECKS:
        named = set(re.findall(r"P\d+", check.source))
        assert named <= known, f"{check.id} rests on facts that do not exist"
        assert named or check.source in ("the contract", "Kirchhoff's law"), f"{check.id} rests on nothing"


def test_findings_bear_on_checks_that_exist() -> None:
    known = {check.id for check in CHECKS}
    for finding in findings():
        assert set(finding.checks) <= known, f"{finding.id} bears on checks that do not exist"
