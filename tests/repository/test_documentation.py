"""The pages read well on a git host: plain Markdown, with what drivegate knows of itself put into it."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
PAGES = sorted(DOCS.rglob("*.md"))
INSERTIONS = runpy.run_path(str(DOCS / "insertions.py"))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(DOCS).as_posix())
def test_a_page_is_plain_and_says_what_is_true_today(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert "```{" not in text, "a git host shows a directive as a block of code without what it inserts"
    assert not re.search(r"\{(?:ref|doc|numref|term)\}`", text), "a git host shows a role as it is written"
    assert not re.search(r"^\([\w-]+\)=$", text, re.MULTILINE), "a git host shows a target as it is written"
    assert INSERTIONS["renewed"](text) == text, "run: python docs/insertions.py"


def test_the_pages_stay_short() -> None:
    counts = INSERTIONS["word_counts"]()
    by_hand = sum(written for written, _ in counts.values())
    assert by_hand <= 36_000, "python docs/insertions.py --words"


def test_a_stale_insertion_is_noticed() -> None:
    page = (DOCS / "checks" / "CNV-1.md").read_text(encoding="utf-8")
    stale = page.replace("- **Limit**:", "- **Limit**: another")
    assert stale != page
    assert INSERTIONS["renewed"](stale) == page


def test_every_insertion_is_used() -> None:
    used = {
        name
        for page in PAGES
        for name in re.findall(r"<!-- inserted: ([\w-]+)", page.read_text(encoding="utf-8"))
    }
    assert used == set(INSERTIONS["INSERTED"])


def test_links_between_pages_lead_to_headings() -> None:
    def slugs(page: Path) -> set[str]:
        text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
        heads = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
        return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}

    broken = []
    for page in PAGES:
        for path, anchor in re.findall(r"\]\(([^)#\s:]*)(?:#([^)\s]+))?\)", page.read_text(encoding="utf-8")):
            target = (page.parent / path).resolve() if path else page
            if not target.exists() or (anchor and anchor not in slugs(target)):
                broken.append(f"{page.name}: {path}#{anchor}")
    assert broken == []
