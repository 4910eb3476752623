"""The page of a comparison of controllers of duty ratios."""

from __future__ import annotations

import copy
from itertools import pairwise
from typing import Any

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from drivegate.contracts.comparison import POINTS
from drivegate.contracts.duty.comparison.page import STEADY_MARKS, STEP_MARKS
from drivegate_models.errors import InputError
from drivegate_reports.comparison.figures import drawn
from drivegate_reports.comparison.inks import Ink, inks_of
from drivegate_reports.comparison.marks import draw_marks
from drivegate_reports.comparison.report import page, view_of
from drivegate_reports.page.style import BLUE, PageFigure, house_style

Document = dict[str, Any]


def _figures(document: Document) -> list[PageFigure]:
    return [
        made for marks in (STEADY_MARKS, STEP_MARKS) for made in drawn(document, marks, inks_of(document))
    ]


def test_the_page_decides_and_shows_everything(duty_comparison: Document) -> None:
    text = page(duty_comparison)
    assert "<h1>foc ranks first on pm-ac-surface, but the checks were not run</h1>" in text
    for name in ("figure-points", "figure-steps"):
        assert text.count(f'<figure class="card" id="{name}"') == 1, name
    for table in ("ranking", "operating points", "steps"):
        assert f'data-name="{table}"' in text
    assert 'id="checks"' not in text, "no checks were made"
    assert page(copy.deepcopy(duty_comparison)) == text


def test_labels_of_many_speeds_and_loads_do_not_overlap() -> None:
    rows = [
        {
            "candidate": "foc",
            "speed_rpm": 520.0 * speed,
            "reference_nm": 0.1234 * load * speed,
            "held": True,
            "loss_above_least_percent": 1.0,
            "current_above_least_percent": 1.0,
            "ripple_percent": 1.0,
        }
        for speed in range(1, 10)
        for load in range(1, 6)
    ]
    with house_style():
        figure = draw_marks({"tables": {POINTS: rows}}, STEADY_MARKS, {"foc": Ink("foc", BLUE, "-", "o")})
        FigureCanvasAgg(figure).draw()
    speeds = figure.axes[0].texts
    assert [text.get_text() for text in speeds[:2]] == ["520 rpm", "1040"]
    for texts in (speeds, [text for text in figure.axes[-1].get_xticklabels() if text.get_text()]):
        upright = [text for text in texts if text.get_rotation() == 90]
        boxes = [text.get_window_extent() for text in upright or texts]
        # A turned text takes its height in width, however long it is.
        widths = [
            box.width if upright else text.get_fontsize() for box, text in zip(boxes, texts, strict=True)
        ]
        for (one, other), width in zip(pairwise(boxes), widths, strict=False):
            assert other.x0 - one.x0 >= 0.9 * width, "labels overlap"


def test_points_that_are_not_held_are_reported_and_not_drawn(duty_comparison: Document) -> None:
    view = view_of(duty_comparison)
    assert view.sentences[1][1].startswith("holds 6 of 10 operating points")
    points, steps = _figures(duty_comparison)
    assert "foc: loss above least (%) from 11.10 to 11.10" in points.alternative
    assert "foc-mtpa: overshoot (%) from 7.00 to 7.00" in steps.alternative, "no rise time is known"


def test_where_nobody_ran_the_page_says_so(duty_comparison: Document) -> None:
    nothing = copy.deepcopy(duty_comparison)
    nothing["tables"] |= {"operating_points": [], "steps": []}
    nothing["tables"]["ranking"] = [
        row | {"rank": None, "status": "faulted", "loss_above_least_percent": None}
        for row in nothing["tables"]["ranking"]
    ]
    assert _figures(nothing) == []
    assert "No candidate could be compared on pm-ac-surface" in page(nothing)


def test_what_a_candidate_says_is_escaped(duty_comparison: Document) -> None:
    hostile = "<script>alert(1)</script>$x$"
    changed = copy.deepcopy(duty_comparison)
    changed["candidates"][0]["label"] = hostile
    for rows in changed["tables"].values():
        for row in rows:
            if row["candidate"] == "foc":
                row["candidate"] = hostile
    text = page(changed)
    assert "<script>alert(1)" not in text
    assert "&lt;script&gt;alert(1)" in text


def test_another_kind_or_a_newer_one_is_refused(duty_comparison: Document) -> None:
    with pytest.raises(InputError, match="schema 2"):
        page(duty_comparison | {"schema": 2})
    with pytest.raises(InputError, match="kind"):
        view_of(duty_comparison | {"kind": "drive-comparison"})


def test_what_was_followed_is_reported(duty_comparison: Document) -> None:
    assert "torque, at held speeds" in page(duty_comparison)
    drive = duty_comparison["drive"] | {"speed_tolerance_rpm": 2.5}
    text = page({**duty_comparison, "reference": "speed", "drive": drive})
    assert "speed, under a constant load" in text
    assert "2.500 rpm" in text
