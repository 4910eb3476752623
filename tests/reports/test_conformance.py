"""The conformance page: complete in itself, harmless whatever a candidate says, and the same every time."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

from drivegate_cases.facts import facts, findings, open_assumptions
from drivegate_models.errors import InputError
from drivegate_reports.conformance import REPORT_FILE, page, write
from drivegate_reports.page_figures import page_figures
from drivegate_reports.published_facts import comparisons
from drivegate_reports.recomputed_findings import recomputed_findings

Factory = Callable[..., dict[str, Any]]

HOSTILE = "<script>alert(1)</script><img src=x onerror=alert(2)>\"'&{{7*7}}</style></pre>\u202e\x00"
VOID = {"meta", "br", "link", "img", "input", "hr"}


class Elements(HTMLParser):
    """Elements of a page, with what is open at the end."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.tags: Counter[str] = Counter()
        self.attributes: list[tuple[str, str, str]] = []
        self.text: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags[tag] += 1
        self.attributes += [(tag, name, value or "") for name, value in attrs]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags[tag] += 1
        self.attributes += [(tag, name, value or "") for name, value in attrs]

    def handle_endtag(self, tag: str) -> None:
        assert self.open, f"</{tag}> closes nothing"
        assert self.open[-1] == tag, f"</{tag}> closes <{self.open[-1]}>"
        self.open.pop()

    def handle_data(self, data: str) -> None:
        self.text.append(data)


def hostile_document(make_document: Factory, make_check: Factory) -> dict[str, Any]:
    scenario = {"name": HOSTILE, HOSTILE: HOSTILE}
    check = make_check(
        HOSTILE,
        requirement=HOSTILE,
        source=HOSTILE,
        level=HOSTILE,
        limit=HOSTILE,
        verdict="fail",
        measured=HOSTILE,
        message=HOSTILE,
        scenario=scenario,
        counterexample=scenario,
    )
    fault = {
        "kind": HOSTILE,
        "message": HOSTILE,
        "phase": HOSTILE,
        "error": HOSTILE,
        "traceback": HOSTILE,
        "step": 1,
        "time_s": 0.5,
        "sense": {HOSTILE: HOSTILE},
    }
    candidate = {
        "name": HOSTILE,
        "kind": HOSTILE,
        "specification": HOSTILE,
        "hash": HOSTILE,
        "declaration": {HOSTILE: HOSTILE},
    }
    return make_document(
        candidate=candidate,
        verdict=HOSTILE,
        effort=HOSTILE,
        checks=[check],
        faults=[fault],
        provenance={HOSTILE: HOSTILE},
        timing={HOSTILE: HOSTILE},
    )


def test_the_page_has_all_its_sections(passing_page: str) -> None:
    text = " ".join(Elements(passing_page).text)
    for heading in ("Checks", "Figures", "Published against ours", "Findings", "Assumptions", "Provenance"):
        assert f">{heading}</h2>" in passing_page, f"the section '{heading}' is missing"
    for said in (
        "golden section",
        "Every required check is met",
        "131",
        "drivegate check",
        "met in all 12 runs",
    ):
        assert said in text, f"the page does not say '{said}'"
    assert "Faults" not in text, "a candidate without faults has no such section"
    for entry in (*facts(), *open_assumptions()):
        assert entry.id in text, f"{entry.id} is missing"
    for finding in findings():
        assert f"{finding.id}: {finding.title}" in text, f"the finding {finding.id} is missing"
    assert passing_page.count("<figcaption>") == 4, "the page has four figures with captions"


def test_a_failure_shows_its_fault_margin_and_counterexample(failing_page: str) -> None:
    text = " ".join(Elements(failing_page).text)
    for said in (
        "exception",
        "−3.2",
        "speed error 21 rpm",
        "angle = 1 / 0",
        "after 2400 steps, at 1.2 s",
        "counterexample",
    ):
        assert said in text, f"the page does not say '{said}'"
    assert 'href="counterexamples/CNV-1.json"' in failing_page


def test_the_page_is_well_formed(passing_page: str, failing_page: str) -> None:
    for text in (passing_page, failing_page):
        elements = Elements(text)
        assert elements.open == [], f"not closed: {elements.open}"
        identifiers = [value for _, name, value in elements.attributes if name == "id"]
        repeated = [value for value, count in Counter(identifiers).items() if count > 1]
        assert repeated == [], f"the identifiers {repeated[:3]} come more than once"
        referred = {
            value[1:]
            for _, name, value in elements.attributes
            if name.endswith("href") and value.startswith("#")
        }
        referred |= {value for _, name, value in elements.attributes if name == "aria-labelledby"}
        referred |= set(re.findall(r"url\(#([^)]+)\)", text))
        assert referred <= set(identifiers), (
            f"nothing has the identifiers {sorted(referred - set(identifiers))}"
        )


def test_a_browser_fetches_and_runs_nothing(passing_page: str) -> None:
    elements = Elements(passing_page)
    assert not {"script", "link", "img", "iframe", "object", "base", "form"} & set(elements.tags)
    assert "://" not in passing_page, "the page names an address"
    assert not [name for _, name, _ in elements.attributes if name.startswith("on")], (
        "an element has a handler"
    )
    assert not re.search(r"@import|url\((?!#)", passing_page), "a style fetches something"
    assert "default-src 'none'" in passing_page, "the page has no content policy"


def test_the_page_is_accessible(passing_page: str) -> None:
    elements = Elements(passing_page)
    assert {"header", "nav", "main", "footer"} <= set(elements.tags), "a landmark is missing"
    assert elements.tags["h1"] == 1
    drawings = [value for _, name, value in elements.attributes if (name, value) == ("role", "img")]
    assert len(drawings) == 4, "each figure is one image"
    labels = [value for tag, name, value in elements.attributes if (tag, name) == ("div", "aria-label")]
    assert len([label for label in labels if len(label) > 80]) == 4, "each figure is told in words"
    assert ("html", "lang", "en") in elements.attributes


def test_hostile_text_stays_text(make_document: Factory, make_check: Factory) -> None:
    text = page(hostile_document(make_document, make_check))
    elements = Elements(text)
    assert not {"script", "img"} & set(elements.tags), "a candidate's text became an element"
    assert not [name for _, name, _ in elements.attributes if name.startswith("on")]
    assert "{{7*7}}" in "".join(elements.text), "a candidate's text was evaluated"
    assert "\x00" not in text
    assert "\u202e" not in text, "a mark of writing direction reaches the page"


def test_the_same_document_gives_the_same_bytes(failing: dict[str, Any], failing_page: str) -> None:
    page_figures.cache_clear()
    comparisons.cache_clear()
    recomputed_findings.cache_clear()
    assert page(failing) == failing_page


def test_write_makes_one_small_file(passing: dict[str, Any], passing_page: str, tmp_path: Path) -> None:
    path = write(passing, tmp_path)
    assert path == tmp_path / REPORT_FILE
    assert [entry.name for entry in tmp_path.iterdir()] == [REPORT_FILE], "something was left beside the page"
    assert path.read_text(encoding="utf-8") == passing_page
    assert path.stat().st_size < 3_000_000


def test_a_folder_that_does_not_exist_is_told(passing: dict[str, Any], tmp_path: Path) -> None:
    with pytest.raises(InputError, match="missing"):
        write(passing, tmp_path / "missing")
