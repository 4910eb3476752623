"""Words on the figures of the reproduction keep off the curves, and off each other."""

from __future__ import annotations

import itertools

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from drivegate_lab.paper.catalogue import FIGURES, PaperFigure
from drivegate_reports.page.style import house_style

THIN = 0.95
"""Lines up to this width (pt) are guides or context, which words may cross."""


@pytest.mark.one_in(4)
@pytest.mark.parametrize("figure", FIGURES, ids=lambda figure: figure.name)
def test_no_word_lies_on_a_curve_or_on_another_word(figure: PaperFigure) -> None:
    with house_style():
        drawn = figure.draw(figure.compute())
        FigureCanvasAgg(drawn)
        drawn.draw_without_rendering()
        struck = []
        for panel in drawn.axes:
            boxes = {text.get_text(): text.get_window_extent() for text in panel.texts if text.get_text()}
            curves = [line for line in panel.lines if line.get_linewidth() > THIN]
            for (word, box), line in itertools.product(boxes.items(), curves):
                path = line.get_path().transformed(line.get_transform())
                if len(path.vertices) > 1 and path.intersects_bbox(box, filled=False):
                    struck.append(f"“{word}” lies on a curve in {line.get_color()}")
            struck += [
                f"“{one}” lies on “{other}”"
                for (one, first), (other, second) in itertools.combinations(boxes.items(), 2)
                if first.overlaps(second)
            ]
    assert struck == []
