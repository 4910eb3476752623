"""The page of the reproduction in a real browser: its long table is filtered by words."""

import pytest
from tests.reports.test_browser import Open

pytestmark = pytest.mark.needs("browser")


def test_tables_filter_by_words(opened: Open) -> None:
    page = opened("reproduction")
    rows = page.locator("table[data-name=numbers] tbody tr:visible")
    before = rows.count()
    field = page.get_by_label("Show only rows of “numbers” with")
    field.fill("RIPPLE p8")
    assert 1 < rows.count() < before
    assert all("ripple" in text.lower() for text in rows.all_inner_texts())
    assert page.locator("label.filter output").first.inner_text() == f"{rows.count()} of {before}"
    field.fill("")
    assert rows.count() == before
