"""The conformance page: complete in itself, harmless whatever a candidate says, and the same every time."""

from __future__ import annotations

import base64
import copy
import hashlib
import re
from collections import Counter
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

from drivegate_models.errors import InputError
from drivegate_reports.conformance.report import REPORT_FILE, page, write

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
        drive={"name": HOSTILE, "kind": HOSTILE, "hash": HOSTILE},
        verdict=HOSTILE,
        effort=HOSTILE,
        checks=[check],
        faults=[fault],
        provenance={HOSTILE: HOSTILE},
        timing={HOSTILE: HOSTILE},
    )


def test_the_page_has_all_its_sections(passing_page: str) -> None:
    text = " ".join(Elements(passing_page).text)
    for heading in (
        "What the verdict rests on",
        "Checks",
        "Worst runs",
        "Traceability",
        "Provenance",
    ):
        assert f">{heading}</span>" in passing_page, f"the section '{heading}' is missing"
    for said in (
        "golden section",
        "Every required check is met",
        "131",
        "drivegate check",
        "met in all 12 runs",
    ):
        assert said in text, f"the page does not say '{said}'"
    assert "Faults" not in text, "a candidate without faults has no such section"
    assert "Counterexamples" not in text, "a candidate that fails nowhere has no such section"
    assert passing_page.count("<figcaption>") == 0, "a result without recordings has no figures"


def test_the_page_names_the_drive(make_document: Factory, make_check: Factory) -> None:
    drive = {"name": "my own drive", "kind": "half-bridge", "hash": "5eed", "specification": "my drive.toml"}
    text = Elements(page(make_document(checks=[make_check("CNV-1")], drive=drive))).text
    assert text.count("my own drive") == 2, "it stands in the head and in the provenance"
    assert "5eed" in text
    assert any("--drive 'my drive.toml'" in part for part in text), "the next step would be on another drive"


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


def test_a_recorded_run_is_drawn_accounted_for_and_can_be_repeated(recorded_page: str) -> None:
    elements = Elements(recorded_page)
    text = " ".join(" ".join(elements.text).split())
    for said in (
        "the angle passed 51.9°, the smallest at which the motor can give the 9.8 N·m demanded",
        "236 rpm below the reference",
        "made simpler in 11 runs",
        "least beyond −10, median −1.45, greatest +0.9",
        "drivegate replay counterexamples/CNV-1.json --candidate 'golden.py:Golden Section' --plot CNV-1.svg",
        "a known weakness",
    ):
        assert said in text, f"the page does not say '{said}'"
    assert recorded_page.count("<figcaption>") == 3, (
        "the distribution of margins, one run that two checks share, and the drive"
    )
    assert 'href="#run-1"' in recorded_page, "the second check refers to the figure of the first"


def test_gaps_in_the_evidence_are_reported(recorded_page: str) -> None:
    text = " ".join(Elements(recorded_page).text)
    assert "ROB-2 is not in this result." in text


def test_the_page_is_well_formed(passing_page: str, failing_page: str, recorded_page: str) -> None:
    for text in (passing_page, failing_page, recorded_page):
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


def test_a_browser_fetches_nothing_and_runs_one_script(recorded_page: str) -> None:
    elements = Elements(recorded_page)
    assert not {"link", "img", "iframe", "object", "base", "form"} & set(elements.tags)
    assert elements.tags["script"] == 1
    assert "Copyright (c) 2022 Leon Sorokin" in recorded_page, "uPlot keeps its licence"
    named = recorded_page.replace("/*! https://github.com/leeoniya/uPlot", "")
    assert "://" not in named, "the page names an address"
    script = recorded_page.rpartition("<script>")[2].partition("</script>")[0]
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    policies = [value for tag, name, value in elements.attributes if (tag, name) == ("meta", "content")]
    assert any(f"script-src 'sha256-{digest}'" in policy for policy in policies), (
        "the policy forbids the script"
    )
    assert not [name for _, name, _ in elements.attributes if name.startswith("on")], (
        "an element has a handler"
    )
    assert not re.search(r"@import|url\((?!#)", recorded_page), "a style fetches something"
    assert any("default-src 'none'" in policy for policy in policies), "the page has no content policy"


def test_the_page_is_accessible(recorded_page: str) -> None:
    elements = Elements(recorded_page)
    assert {"header", "nav", "main", "footer"} <= set(elements.tags), "a landmark is missing"
    assert elements.tags["h1"] == 1
    drawings = [value for _, name, value in elements.attributes if (name, value) == ("role", "img")]
    assert len(drawings) == 3, "each figure is one image"
    labels = [value for tag, name, value in elements.attributes if (tag, name) == ("div", "aria-label")]
    assert len([label for label in labels if len(label) > 80]) == 3, "each figure is described in words"
    assert ("html", "lang", "en") in elements.attributes


def test_hostile_text_stays_text(make_document: Factory, make_check: Factory) -> None:
    text = page(hostile_document(make_document, make_check))
    elements = Elements(text)
    assert elements.tags["script"] == 1, "a candidate's text became a script"
    assert elements.tags["img"] == 0, "a candidate's text became an element"
    assert not [name for _, name, _ in elements.attributes if name.startswith("on")]
    assert "{{7*7}}" in "".join(elements.text), "a candidate's text was evaluated"
    assert "\x00" not in text
    assert "\u202e" not in text, "a mark of writing direction reaches the page"


@pytest.mark.parametrize(
    "recording",
    [
        HOSTILE,
        [],
        {"trace": -1, "start_s": 0.0, "end_s": 1.0},
        {"trace": 7, "start_s": 0.0, "end_s": 1.0},
        {"trace": 0, "start_s": HOSTILE, "end_s": None},
    ],
)
def test_a_recording_that_is_none_is_left_out(recorded: dict[str, Any], recording: object) -> None:
    changed = copy.deepcopy(recorded)
    for check in changed["checks"]:
        check["recording"] = recording
    assert page(changed).count("<figcaption>") == 2, "only margins and drive are drawn"


@pytest.mark.parametrize("values", [HOSTILE, ["1", "2"], [1.0], [0.0, 1e300], [None, 1.0], [0.0] * 400])
def test_signals_that_are_none_are_left_out(recorded: dict[str, Any], values: object) -> None:
    changed = copy.deepcopy(recorded)
    changed["traces"][0]["speed_rpm"] = values
    assert page(changed).count("<figcaption>") == 2, "only margins and drive are drawn"


def test_a_megabyte_of_message_stays_readable(make_document: Factory, make_check: Factory) -> None:
    long = "<b>" * 350_000
    text = page(make_document(checks=[make_check("CNV-1", message=long, measured=long)], verdict=long))
    assert len(text) < 400_000, "texts are bounded"
    assert Elements(text).tags["b"] == 0


def test_a_settled_date_makes_equal_results_equal_pages(
    recorded: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    later = {
        **recorded,
        "timing": {"started_utc": "2031-01-01T00:00:00+00:00", "seconds": 99.0, "workers": 7},
    }
    text = page(recorded)
    assert text == page(later), "times reach a page whose date is settled"
    assert "2023-11-14" in text


def test_write_makes_one_small_file(passing: dict[str, Any], passing_page: str, tmp_path: Path) -> None:
    path = write(passing, tmp_path)
    assert path == tmp_path / REPORT_FILE
    assert [entry.name for entry in tmp_path.iterdir()] == [REPORT_FILE], "something was left beside the page"
    assert path.read_text(encoding="utf-8") == passing_page
    assert path.stat().st_size < 3_000_000


def test_a_folder_that_does_not_exist_is_reported(passing: dict[str, Any], tmp_path: Path) -> None:
    with pytest.raises(InputError, match="missing"):
        write(passing, tmp_path / "missing")
