"""The pages in a real browser: no error, nothing missing, sorting and filtering, narrow screens, print, access."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page
from tests.reports.page_names import PAGE_NAMES

pytestmark = pytest.mark.needs("browser")
MOST_HEIGHT = 12_000
"""Height of a report in a window of a desktop, 1280 wide (CSS pixels)."""
A4_WIDTH = 703
"""Width between the margins of a printed page (CSS pixels)."""
MISSING = """() => [...document.querySelectorAll('a[href]')]
  .map(anchor => anchor.getAttribute('href'))
  .filter(href => href.startsWith('#') && !document.getElementById(decodeURIComponent(href.slice(1))))"""
FILES = """() => [...document.querySelectorAll('a[href], img[src]')]
  .map(item => item.getAttribute('href') ?? item.getAttribute('src')).filter(to => !to.startsWith('#'))"""
CUT = """() => [...document.querySelectorAll('table, figure svg')]
  .filter(item => item.getClientRects().length && item.getBoundingClientRect().right > innerWidth + 1)
  .map(item => `${Math.round(item.getBoundingClientRect().right)} px: ${item.outerHTML.slice(0, 80)}`)"""


Open = Callable[..., Page]


@pytest.fixture
def opened(browser: Browser, pages: dict[str, Path]) -> Iterator[Open]:
    """Open a page; whatever its console reports is an error at the end."""
    reported: list[str] = []
    contexts = []

    def open_page(name: str, width: int = 1280, **options: Any) -> Page:
        context = browser.new_context(viewport={"width": width, "height": 900}, **options)
        contexts.append(context)
        page = context.new_page()
        page.on("console", lambda message: reported.append(message.text))
        page.on("pageerror", lambda error: reported.append(str(error)))
        page.on("requestfailed", lambda request: reported.append(f"failed: {request.url}"))
        page.goto(pages[name].as_uri())
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert reported == [], f"the browser complains: {reported}"


EACH = pytest.mark.parametrize("name", PAGE_NAMES)


@EACH
def test_every_anchor_and_file_resolves(opened: Open, pages: dict[str, Path], name: str) -> None:
    page = opened(name)
    assert page.evaluate(MISSING) == [], "an anchor leads nowhere"
    for file in page.evaluate(FILES):
        assert (pages[name].parent / file).is_file(), f"the page refers to {file}, which is not beside it"
    assert page.evaluate("[...document.images].every(image => image.naturalWidth > 0)")
    page.evaluate("document.querySelectorAll('details').forEach(part => part.open = true)")
    page.emulate_media(media="print")
    drawings = page.locator("figure svg")
    assert drawings.count() > 1, "the page has no figures"
    assert all((box := drawing.bounding_box()) and box["height"] > 100 for drawing in drawings.all())


@pytest.mark.parametrize("name", ["conformance", "duty"])
def test_a_report_is_short_until_it_is_unfolded(opened: Open, name: str) -> None:
    page = opened(name)
    assert page.evaluate("document.documentElement.scrollHeight") <= MOST_HEIGHT
    link = page.locator("table[data-name=checks] tbody th a").last
    folded = page.locator(f"details{link.get_attribute('href')}")
    if folded.count():
        link.click()
        assert folded.evaluate("part => part.open"), "a link into what is folded opens it"


def test_the_table_of_checks_fits_a_phone(opened: Open) -> None:
    page = opened("conformance", width=390)
    heads = page.locator("table[data-name=checks] thead th:visible")
    assert [text.split()[0] for text in heads.all_inner_texts()] == ["check", "verdict", "margin"]
    assert page.locator("table[data-name=checks]").evaluate("table => table.offsetWidth") <= 390


@EACH
def test_nothing_scrolls_sideways_on_a_narrow_screen(opened: Open, name: str) -> None:
    page = opened(name, width=390)
    assert page.evaluate("document.documentElement.scrollWidth") == 390


@EACH
def test_print_cuts_no_table(opened: Open, name: str) -> None:
    page = opened(name, width=A4_WIDTH)
    page.emulate_media(media="print")
    assert page.evaluate(CUT) == [], "wider than the paper"
    assert page.evaluate("document.documentElement.scrollWidth") <= A4_WIDTH


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("name", "scheme"),
    [*((name, "light") for name in PAGE_NAMES), ("conformance", "dark"), ("ratios", "dark")],
)
def test_axe_finds_no_fault(opened: Open, name: str, scheme: str) -> None:
    # The content policy lets no other script in, and axe is one.
    page = opened(name, bypass_csp=True, color_scheme=scheme)
    page.evaluate((files("axe_playwright_python") / "axe.min.js").read_text(encoding="utf-8"))
    # Without the lists of all that is in order.
    found = page.evaluate("axe.run({ resultTypes: ['violations'] })")["violations"]
    assert [(fault["id"], fault["impact"], fault["nodes"][0]["html"]) for fault in found] == []


def test_the_policy_lets_no_other_script_in(browser: Browser, pages: dict[str, Path]) -> None:
    page = browser.new_page()
    page.goto(pages["conformance"].as_uri())
    page.evaluate(
        "() => { const made = document.createElement('script'); made.textContent = 'window.ran = true';"
        " document.body.append(made); }"
    )
    assert page.evaluate("window.ran") is None
    page.close()


def test_a_trace_is_zoomed_and_read_off(opened: Open) -> None:
    page = opened("conformance")
    box = page.locator(".trace:visible").first
    assert box.locator("canvas").count() == 4, "a plot for each panel"
    plot = box.locator(".u-over").first
    plot.hover(position={"x": 300, "y": 40})
    first = box.locator(".readout").all_inner_texts()
    assert all(re.match(r"[\d.]+ s: .+ [−\d.-]+", text) for text in first), first
    assert len({text.split(" s:")[0] for text in first}) == 1, "all panels are read at the same time"
    box.get_by_role("button", name="Closer").click()
    plot.hover(position={"x": 300, "y": 40})
    assert box.locator(".readout").first.inner_text() != first[0]
    page.emulate_media(media="print")
    assert not box.is_visible()
    assert page.locator(".traced figure svg").first.is_visible(), "paper has the drawn figure"


def test_tables_sort_by_number_and_by_text(opened: Open) -> None:
    page = opened("conformance")
    table = page.locator("table[data-name=checks]")
    heads = table.locator("tbody th")
    table.get_by_role("button", name="margin").click()
    assert heads.all_inner_texts() == ["CNV-1", "CNV-3", "CMD-1"], "by margin, −46.3 first"
    table.get_by_role("button", name="margin").click()
    assert heads.all_inner_texts() == ["CMD-1", "CNV-3", "CNV-1"], "the other way round"
    assert table.locator("th[aria-sort=descending]").inner_text().startswith("margin")
    table.get_by_role("button", name="check").click()
    assert heads.all_inner_texts() == ["CMD-1", "CNV-1", "CNV-3"], "by name"


@EACH
def test_without_script_the_page_reads_the_same(opened: Open, name: str) -> None:
    scripted, plain = opened(name), opened(name, java_script_enabled=False)
    assert plain.locator("button, input").count() == 0, "a control that does nothing"
    for table in ("tbody tr", "figure", "article"):
        assert plain.locator(table).count() == scripted.locator(table).count()


def test_a_command_is_copied_and_a_section_linked(opened: Open) -> None:
    page = opened("conformance")
    page.evaluate("() => { navigator.clipboard.writeText = async (text) => { window.copied = text; }; }")
    command = page.locator("code.command").first
    command.locator("xpath=following-sibling::button[1]").click()
    assert page.evaluate("window.copied") == command.inner_text()
    assert page.locator(".copy-state").first.inner_text().strip() == "copied"
    sign = page.locator("a.sign").nth(1)
    sign.click()
    assert page.evaluate("location.hash") == sign.get_attribute("href")
    page.emulate_media(media="print")
    assert not sign.is_visible()


def test_failures_come_first(opened: Open) -> None:
    page = opened("conformance")
    levels = page.locator("table[data-name=checks] tbody tr td:nth-child(2)").all_inner_texts()
    failing = [text.startswith("fail") for text in levels]
    assert failing == sorted(failing, reverse=True), levels
