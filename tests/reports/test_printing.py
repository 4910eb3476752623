"""Each page on paper, measured on the PDF that a browser makes: sheets, how full, letters beyond or broken."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser
from pypdfium2 import PdfDocument, PdfObject, PdfPage, raw
from tests.reports.page_names import PAGE_NAMES

from drivegate.candidates.declaration import Declaration
from drivegate.checks.check import Check
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_reports.conformance.report import write

pytestmark = pytest.mark.needs("browser")
MOST_SHEETS = {"whole": 10, "conformance": 10, "duty": 10}
"""A pass is to be read in so many sheets."""
MOST_SHEETS_OF_ANY = 17
LEAST_FILLED = 0.5
"""How far down every sheet but the last is filled (share of its height)."""
FOOT = 43.0
"""Height of the lower margin with the number of the sheet (pt)."""
MARGIN = 30.0
"""What stays white on the left and the right (pt)."""
WORDS = """() => [...document.querySelectorAll('th, td, h1, h2, h3, h4, .badge')]
  .filter(item => item.getClientRects().length && getComputedStyle(item).overflowWrap !== 'anywhere'
    && !item.querySelector('code') && !item.closest('svg')).flatMap(item => item.innerText.split(/\\s+/))"""
PART = re.compile(r"[A-Za-z]{2,}")


@dataclass(frozen=True)
class Paper:
    """What was measured: filled share of each sheet, words broken, letters beyond the margins, sizes (pt)."""

    filled: list[float]
    broken: set[str]
    beyond: list[str]
    sizes: list[float]
    large: dict[str, float]


@dataclass(frozen=True)
class Letter:
    """A letter, or a space between words, and where it is from the left and from the lower edge (pt)."""

    text: str
    left: float
    bottom: float
    right: float
    size: float


def letters_of(sheet: PdfPage) -> list[Letter]:
    """Read the letters of a sheet in their order, with the spaces that are not printed but part words."""
    text = sheet.get_textpage()
    letters, matrix = [], raw.FS_MATRIX()
    for place in range(text.count_chars()):
        left, bottom, right, _ = text.get_charbox(place)
        raw.FPDFText_GetMatrix(text, place, matrix)
        size = raw.FPDFText_GetFontSize(text, place) * math.hypot(matrix.c, matrix.d)
        letters.append(Letter(chr(raw.FPDFText_GetUnicode(text, place)), left, bottom, right, size))
    return letters


def paths_of(sheet: PdfPage) -> Iterator[PdfObject]:
    """Return what is drawn on a sheet."""
    return sheet.get_objects(filter=[raw.FPDF_PAGEOBJ_PATH])


@cache
def printed(browser: Browser, path: Path, paper: str) -> Paper:
    page = browser.new_page()
    page.goto(path.as_uri())
    page.emulate_media(media="print")
    wanted = {part for word in page.evaluate(WORDS) for part in PART.findall(word)}
    data = page.pdf(format=paper)
    page.close()
    measured, found = Paper([], set(), [], [], {}), set()
    with closing(PdfDocument(data)) as document:
        for sheet in document:
            letters, (width, height) = letters_of(sheet), sheet.get_size()
            drawn = [bottom for _, bottom, _, _ in (path.get_bounds() for path in paths_of(sheet))]
            bottoms = [bottom for bottom in (*(each.bottom for each in letters), *drawn) if bottom >= FOOT]
            measured.filled.append(1.0 - min(bottoms, default=height) / height)
            shown = [each for each in letters if each.bottom >= FOOT and each.text.strip()]
            measured.beyond.extend(
                each.text for each in shown if each.left < MARGIN or each.right > width - MARGIN
            )
            measured.sizes.extend(each.size for each in shown)
            for word in re.finditer(r"\S+", "".join(each.text for each in letters)):
                found |= set(PART.findall(word[0]))
                size = max(each.size for each in letters[slice(*word.span())])
                measured.large[word[0]] = max(size, measured.large.get(word[0], 0.0))
    measured.broken.update(word for word in wanted if not {word, word.upper()} & found)
    return measured


def applies(check: Check, drive: DriveDocument) -> bool:
    return check.reason_not_applicable(Declaration(), drive) is None


@pytest.fixture(scope="module")
def whole_pass(tmp_path_factory: pytest.TempPathFactory, recorded: dict[str, Any]) -> Path:
    """Return the page of a pass with every check of its drive, two advisory ones not met, as a search leaves it."""
    failed, met = recorded["checks"][0], recorded["checks"][1]
    checks = []
    drive = load_drive("paper-5-phase")
    judged = [check for check in CHECKS if applies(check, drive)]
    for place, check in enumerate(judged):
        like = failed | {"verdict": "fail", "level": "advisory"} if place in (6, 7) else met
        words = {"id": check.id, "requirement": check.requirement, "source": check.source}
        recording = like["recording"] | {"start_s": 0.1 * place}
        checks.append(
            like
            | words
            | {"limit": check.limit, "recording": recording, "measured": "Σ|i| varies by 0.552 % at 1460 rpm"}
        )
    folder = tmp_path_factory.mktemp("whole")
    return write(recorded | {"verdict": "pass", "exit_code": 0, "checks": checks}, folder)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("paper", ["A4", "Letter"])
@pytest.mark.parametrize("name", ["whole", *PAGE_NAMES])
def test_paper_shows_it_as_a_review_would_want(
    browser: Browser, pages: dict[str, Path], whole_pass: Path, name: str, paper: str
) -> None:
    measured = printed(browser, whole_pass if name == "whole" else pages[name], paper)
    assert len(measured.filled) <= MOST_SHEETS.get(name, MOST_SHEETS_OF_ANY), f"{len(measured.filled)} sheets"
    empty = [place + 1 for place, share in enumerate(measured.filled[:-1]) if share < LEAST_FILLED]
    assert not empty, f"sheets {empty} are half empty: {measured.filled}"
    assert measured.broken == set(), "broken within the word"
    assert measured.beyond == [], "beyond the margins"
    assert min(measured.sizes) > 5.0, "too small to read"


@pytest.mark.parametrize("paper", ["A4", "Letter"])
def test_the_verdict_is_the_largest_word_beside_the_name(
    browser: Browser, whole_pass: Path, paper: str
) -> None:
    large = printed(browser, whole_pass, paper).large
    assert large["PASS"] >= 14.0, "the verdict is small"


def test_the_verdict_is_not_ink_on_its_own_colour(browser: Browser, whole_pass: Path) -> None:
    page = browser.new_page()
    page.goto(whole_pass.as_uri())
    page.emulate_media(media="print")
    style = page.locator(".badge.big").evaluate(
        "item => [getComputedStyle(item).color, getComputedStyle(item).backgroundColor]"
    )
    page.close()
    assert style == ["rgb(0, 102, 75)", "rgba(0, 0, 0, 0)"], "the letters are to stand out from their ground"
