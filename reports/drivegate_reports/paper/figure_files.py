"""A figure of the paper as files of its own: SVG, and PNG for what cannot show that."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import Final

from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_reports.page.style import house_style, svg_document
from drivegate_reports.paper.catalogue import PaperFigure

DOTS_PER_INCH: Final = 160
"""Resolution of the PNG files."""


def write_figure(figure: PaperFigure, folder: Path) -> tuple[Path, Path]:
    """Write a figure as an SVG and a PNG file."""
    stream = BytesIO()
    with house_style():
        drawn = figure.draw(figure.compute())
        vector = svg_document(drawn, figure.name)
        drawn.savefig(stream, format="png", dpi=DOTS_PER_INCH, metadata={"Software": None})
    paths = (folder / f"{figure.name}.svg", folder / f"{figure.name}.png")
    write_atomically(paths[0], vector)
    write_atomically(paths[1], stream.getvalue())
    return paths
