"""The page of a comparison on one drive, from its document alone: the decision in sentences, tables and figures."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from drivegate.contracts.catalogue import comparison_of
from drivegate.contracts.comparison import Comparison, Figure
from drivegate.studies.compare.document import SCHEMA
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.wording import counted
from drivegate_reports.comparison.cells import Sheet, name, written
from drivegate_reports.comparison.figures import drawn
from drivegate_reports.comparison.inks import inks_of
from drivegate_reports.comparison.sheets import joined, table_sheet
from drivegate_reports.page.page import clean, require_document
from drivegate_reports.page.style import PageFigure

REPORT_FILE: Final = "comparison.html"
"""Name of the page in the report's folder."""
_MOST_SENTENCES: Final = 6
_LONGEST_BLOCK: Final = 4_000


def write(document: Mapping[str, Any], folder: Path) -> Path:
    """Write the comparison report."""
    path = folder / REPORT_FILE
    write_atomically(path, page(document))
    return path


def page(document: Mapping[str, Any]) -> str:
    """Make the page."""
    from drivegate_reports.page.page import page_text

    return page_text("comparison.html.j2", view=view_of(document))


@dataclass(frozen=True)
class Trouble:
    """A candidate that could not be compared."""

    candidate: str
    """Its name, and where that was."""
    what: str
    """``refused``, or the kind of fault."""
    message: str
    """What happened."""
    detail: str
    """Traceback; empty where there is none."""


@dataclass(frozen=True, kw_only=True)
class PageSection:
    """A section of the page."""

    name: str
    title: str
    link: str = ""
    """Its anchor, its heading, and what links to it, where that is not the heading."""
    words: tuple[str, ...] = ()
    figures: tuple[PageFigure, ...] = ()
    sheet: Sheet | None = None
    """What it shows."""
    folded: str = ""
    """What opens the table where it is closed at first."""
    links: tuple[tuple[str, str], ...] = ()
    """Names and addresses of other pages."""


@dataclass(frozen=True, kw_only=True)
class ComparisonView:
    """A comparison as the page shows it."""

    subject: str
    """What is compared."""
    headline: str
    """Who is first."""
    sentences: tuple[tuple[str, str], ...]
    """Names, and what is said of each, best first."""
    note: str
    """How candidates are ranked, or what per unit is."""
    sections: tuple[PageSection, ...]
    """The sections, in their order."""
    troubles: tuple[Trouble, ...]
    """Candidates that were refused or failed."""
    method: tuple[str, ...]
    """How the comparison was made."""
    facts: tuple[tuple[str, str], ...]
    provenance: tuple[tuple[str, str], ...]
    """Names and values."""
    file: str
    """Name of the document."""


def view_of(document: Mapping[str, Any]) -> ComparisonView:
    """Prepare a comparison document for the page."""
    comparison = comparison_of(document.get("kind"))
    require_document(document, comparison.kind, SCHEMA, "the comparison")
    return ComparisonView(
        subject=f"of {len(document['candidates'])} candidates",
        headline=_headline(document),
        sentences=tuple(_sentences(document, comparison))[:_MOST_SENTENCES],
        note=f"Rule: {clean(document['rule'])}",
        sections=tuple(_sections(document, comparison)),
        troubles=tuple(troubles_of(document)),
        method=cleaned(comparison.method(document)),
        facts=(
            ("drive", clean(document["drive"]["name"])),
            ("runs of each candidate", str(document["size"]["runs_of_each"])),
            *comparison.shown_facts(document),
            *common_facts(document),
        ),
        provenance=provenance_rows(document),
        file="comparison.json",
    )


def cleaned(texts: Iterable[str]) -> tuple[str, ...]:
    """Make texts printable."""
    return tuple(map(clean, texts))


def common_facts(document: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    """Return names and values about any comparison."""
    return (
        ("effort", clean(document["effort"])),
        ("seed", str(document["seed"])),
        ("date", clean(document["timing"].get("started_utc", "–"))),
    )


def _sections(document: Mapping[str, Any], comparison: Comparison) -> Iterator[PageSection]:
    inks = inks_of(document)
    for section in comparison.sections:
        sheet = table_sheet(document, section.table)
        if sheet is not None:
            yield PageSection(
                name=section.name,
                title=section.title,
                link=section.link,
                words=cleaned(section.words(document)),
                figures=tuple(
                    made for drawing in section.drawings for made in drawn(document, drawing, inks)
                ),
                sheet=sheet,
                folded=section.folded,
            )


def _headline(document: Mapping[str, Any]) -> str:
    rows = [row for row in document["tables"]["ranking"] if row["rank"] == 1]
    first, on = [name(row["candidate"]) for row in rows], f"on {name(document['drive']['name'])}"
    if not first:
        return f"No candidate could be compared {on}"
    words = f"{first[0]} ranks first" if len(first) == 1 else f"{joined(first)} share the first place"
    unjudged = any(row["required_failed"] is None for row in rows)
    return f"{words} {on}{', but the checks were not run' if unjudged else ''}"


def _sentences(document: Mapping[str, Any], comparison: Comparison) -> Iterator[tuple[str, str]]:
    """Describe the first candidate by itself, and every other one by the first, as far as the ranking does."""
    ranked = [row for row in document["tables"]["ranking"] if row["rank"] is not None]
    for place, row in enumerate(ranked):
        against = place > 0 and comparison.ranking.costs
        words = _against(document, comparison, ranked[0], row) if against else _standing(comparison, row)
        yield name(row["candidate"]), words


def _standing(comparison: Comparison, row: Mapping[str, Any]) -> str:
    failed, all_points, held = row["required_failed"], row[comparison.ranking.count], row["points_held"]
    parts = []
    if failed is not None:
        names = f": {clean(row['failed_checks']).replace(' ', ', ')}" if failed else ""
        parts.append(
            f"fails {counted(failed, 'required check')}{names}" if failed else "passes every required check"
        )
    parts.append(
        f"holds {'all' if held == all_points else f'{held} of'} {counted(all_points, 'operating point')}"
    )
    parts += comparison.ranking.standing(dict(row))
    return f"{joined(parts)}."


def _against(
    document: Mapping[str, Any], comparison: Comparison, first: Mapping[str, Any], row: Mapping[str, Any]
) -> str:
    costs, count = comparison.ranking.costs, comparison.ranking.count
    if row[costs[0].above.format("first")] is None:
        words = f"holds no operating point that {name(first['candidate'])} holds"
    else:
        more = " and ".join(_more(row, figure) for figure in costs)
        words = f"takes {more} over the {row['points_shared']} points that both hold"
    lost = row[count] - row["points_held"]
    if lost:
        words += f", but loses {lost} of {row[count]} points"
    if row["required_failed"]:
        words += f", and fails {counted(row['required_failed'], 'required check')}"
    certainty = _certainty(document, costs[0], first["candidate"], row["candidate"])
    return words + (f"; {certainty}." if certainty else ".")


def _more(row: Mapping[str, Any], figure: Figure) -> str:
    """Write how much more a candidate takes than the first, with its share."""
    change = row[figure.above.format("first")]
    digits, level = figure.digits or 0, row[figure.name] - change
    share = f" ({written(100.0 * change / level, 1, signed=True)} %)" if level else ""
    if round(abs(change), digits) == 0.0:
        return f"as much {figure.label}"
    more = "more" if change > 0 else "less"
    return f"{written(abs(change), digits)} {figure.unit} {more} {figure.label}{share}"


def _certainty(document: Mapping[str, Any], figure: Figure, first: str, second: str) -> str:
    unit = figure.unit
    for row in document["tables"].get("differences", ()):
        known = row["where"].startswith("drawn") and row["quantity"] == figure.name
        if known and (row["first"], row["second"]) == (first, second) and row["low"] is not None:
            interval = (
                f"{written(-row['high'], 1, signed=True)} to {written(-row['low'], 1, signed=True)} {unit}"
            )
            where = f"over {row['pairs']} drawn plants with noise that both hold"
            if row["verdict"] == "no real difference":
                return f"{where} there is no real difference in {figure.label} ({interval})"
            return f"{where} the difference is real ({interval})"
    return ""


def troubles_of(document: Mapping[str, Any], place: str = "") -> Iterator[Trouble]:
    """List the candidates that could not be compared, and why; `place` is added to their names."""
    for entry in document["candidates"]:
        label = f"{name(entry['label'])}{place}"
        if entry["refusal"] is not None:
            yield Trouble(label, "refused", clean(entry["refusal"]), "")
        for fault in entry["faults"]:
            detail = clean(fault["traceback"], _LONGEST_BLOCK)
            yield Trouble(label, clean(fault["kind"]), clean(fault["message"]), detail)


def provenance_rows(document: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    """List what a comparison was made with."""
    used = document["provenance"]
    packages = ", ".join(f"{key} {value}" for key, value in used.get("packages", {}).items())
    rows = [(key, value) for key, value in used.items() if key != "packages"]
    hashes = [
        (f"{entry['label']}, {entry['kind']}", entry["hash"])
        for entry in (*document.get("drives", ()), *document["candidates"])
        if entry["hash"]
    ]
    return tuple((name(key), clean(value)) for key, value in (*rows, ("packages", packages), *hashes))
