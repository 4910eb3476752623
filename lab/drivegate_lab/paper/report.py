"""The reproduction of the paper: every figure and number that physics can give, next to what is published."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any, Final

from drivegate.results.provenance import provenance
from drivegate.results.result import finite
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.publication import facts, open_assumptions, publication
from drivegate_lab.paper.catalogue import FIGURES, PaperFigure
from drivegate_lab.paper.drives import reference_drive
from drivegate_lab.paper.facts import all_comparisons
from drivegate_lab.paper.findings import RecomputedFinding, recomputed_findings
from drivegate_lab.paper.verdicts import ComparedStatement, verdict_counts
from drivegate_reports.page.page import page_text
from drivegate_reports.page.style import PageFigure, house_style, page_figure, svg_document

SCHEMA: Final = 1
PAGE_FILE: Final = "reproduction.html"
"""Name of the page in its folder."""
NUMBERS_FILE: Final = "reproduction.json"
"""Name of the document in its folder."""
FIGURE_FOLDER: Final = "figures"
"""Folder of the figures' files."""
DOTS_PER_INCH: Final = 160
"""Resolution of the PNG files."""


@dataclass(frozen=True)
class Reproduced:
    """A figure with the numbers that belong to it."""

    label: str
    """What the paper calls it."""
    figure: PageFigure
    """The figure with its words."""
    files: tuple[str, ...]
    """Its files, relative to the page."""
    rows: tuple[ComparedStatement, ...]
    """Published numbers and statements that it bears on."""


@dataclass(frozen=True)
class NumberRow:
    """A comparison in the table of all."""

    comparison: ComparedStatement
    """The comparison."""
    source: str
    """Where in the paper the published side stands."""
    first: bool
    """Whether it is the first of its fact."""


def reproduce(folder: Path) -> dict[str, Any]:
    """Reproduce the paper into a folder: page, figures as files, and numbers."""
    (folder / FIGURE_FOLDER).mkdir(exist_ok=True)
    compared = all_comparisons()
    figures = [_reproduced(figure, compared, folder) for figure in FIGURES]
    rows = _rows(compared)
    found = recomputed_findings()
    document: dict[str, Any] = finite(_document(figures, rows, found))
    text = page_text(
        "reproduction.html.j2",
        paper=publication().title,
        counts=verdict_counts(compared),
        figures=figures,
        numbers=rows,
        findings=found,
        assumptions=open_assumptions(),
        provenance=_listed(document["provenance"]),
    )
    write_atomically(folder / PAGE_FILE, text)
    write_atomically(folder / NUMBERS_FILE, json.dumps(document, indent=2, allow_nan=False) + "\n")
    return document


def _reproduced(figure: PaperFigure, compared: Sequence[ComparedStatement], folder: Path) -> Reproduced:
    files = _write_figure(figure, folder / FIGURE_FOLDER)
    rows = tuple(row for row in compared if row.fact in figure.facts)
    relative = tuple(path.relative_to(folder).as_posix() for path in files)
    return Reproduced(figure.label, _placed(figure), relative, rows)


def _write_figure(figure: PaperFigure, folder: Path) -> tuple[Path, Path]:
    """Write a figure as SVG, and as PNG for what cannot show that."""
    stream = BytesIO()
    with house_style():
        drawn = figure.draw(figure.compute())
        vector = svg_document(drawn, figure.name)
        drawn.savefig(stream, format="png", dpi=DOTS_PER_INCH, metadata={"Software": None})
    paths = (folder / f"{figure.name}.svg", folder / f"{figure.name}.png")
    write_atomically(paths[0], vector)
    write_atomically(paths[1], stream.getvalue())
    return paths


@cache
def _placed(figure: PaperFigure) -> PageFigure:
    """Compute and draw a figure for the page."""
    data = figure.compute()
    words = figure.alternative(data), figure.caption(data)
    return page_figure(f"figure-{figure.name}", figure.title, lambda: figure.draw(data), *words)


def _rows(compared: Sequence[ComparedStatement]) -> list[NumberRow]:
    sources = {fact.id: fact.source for fact in facts()}
    known: set[str] = set()
    rows = []
    for row in compared:
        rows.append(NumberRow(row, sources.get(row.fact, row.fact), row.fact not in known))
        known.add(row.fact)
    return rows


def _document(
    figures: Sequence[Reproduced], rows: Sequence[NumberRow], found: Sequence[RecomputedFinding]
) -> dict[str, Any]:
    return {
        "schema": SCHEMA,
        "kind": "reproduction",
        "paper": publication().title,
        "drive": reference_drive().name,
        "page": PAGE_FILE,
        "verdicts": dict(verdict_counts([row.comparison for row in rows])),
        "numbers": [asdict(row.comparison) | {"source": row.source} for row in rows],
        "figures": [
            {
                "label": item.label,
                "title": item.figure.title,
                "files": list(item.files),
                "shows": item.figure.alternative,
                "caption": item.figure.caption,
                "facts": sorted({row.fact for row in item.rows}),
            }
            for item in figures
        ],
        "findings": [
            {"id": item.finding.id, "title": item.finding.title, "statement": item.finding.statement}
            | {"numbers": dict(item.numbers)}
            for item in found
        ],
        "assumptions": [item.model_dump(mode="json") for item in open_assumptions()],
        "provenance": provenance(),
    }


def _listed(table: dict[str, Any]) -> list[tuple[str, str]]:
    entries: list[tuple[str, str]] = []
    for key, value in table.items():
        items = value.items() if isinstance(value, dict) else [("", value)]
        entries += [(f"{key} {name}".strip().replace("_", " "), str(item)) for name, item in items]
    return entries
