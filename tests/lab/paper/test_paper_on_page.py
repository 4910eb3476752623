"""What the page of a check shows of the paper: on the paper's drive, the same every time, and on no other."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from markupsafe import escape

from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.publication import facts, findings, open_assumptions
from drivegate_lab.paper.facts import comparisons
from drivegate_lab.paper.findings import recomputed_findings
from drivegate_reports.conformance.coverage import drive_of
from drivegate_reports.conformance.report import page, prepare

Factory = Callable[..., dict[str, Any]]


@pytest.mark.nightly
def test_the_same_document_gives_the_same_bytes(recorded: dict[str, Any], recorded_page: str) -> None:
    comparisons.cache_clear()
    recomputed_findings.cache_clear()
    assert page(recorded) == recorded_page


def test_the_page_on_the_drive_of_the_paper_has_all_that_is_published_of_it(recorded_page: str) -> None:
    for heading in ("Published against ours", "Findings", "Assumptions"):
        assert f">{heading}</span>" in recorded_page, f"the section '{heading}' is missing"
    for entry in (*facts(), *open_assumptions()):
        assert entry.id in recorded_page, f"{entry.id} is missing"
    for finding in findings():
        assert f"{finding.id}: {escape(finding.title)}" in recorded_page, (
            f"the finding {finding.id} is missing"
        )
    assert "P1, phases, poles and conduction window, is held by no check of candidates" in recorded_page


def test_the_page_of_another_kind_of_drive_computes_nothing_of_the_papers(
    make_document: Factory, monkeypatch: pytest.MonkeyPatch
) -> None:
    def compiles(*_: object, **__: object) -> None:
        pytest.fail("the page computes numbers of the paper's drive, whose plant would have to be compiled")

    monkeypatch.setattr("drivegate_lab.paper.evidence.comparisons", compiles)
    monkeypatch.setattr("drivegate_lab.paper.evidence.recomputed_findings", compiles)
    star = load_drive("star-3-phase")
    drive = {"name": star.name, "kind": star.kind, "hash": "5eed", "document": star.to_mapping()}
    text = page(make_document(drive=drive))
    for heading in ("Published against ours", "Findings", "What holds each fact"):
        assert heading not in text, f"'{heading}' is about the paper's drive"
    assert "#fact-" not in text
    assert not [finding.id for finding in findings() if f"{finding.id}:" in text]


def test_what_pages_show_of_the_paper_is_not_computed_again(recorded: dict[str, Any]) -> None:
    kept = (comparisons, recomputed_findings)
    for each in kept:
        each.cache_clear()
    prepare(drive_of(recorded))
    made = [each.cache_info().misses for each in kept]
    page(recorded)
    assert [each.cache_info().misses for each in kept] == made
