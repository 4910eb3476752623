"""The comparison page and its figures, from a document made up for them."""

import copy
import io
import json
import math
import re

import numpy as np
import pytest

from drivegate.contracts.current.comparison.page import AFTER_CHANGE, DIFFERENCES, MAPS, OVER_SPEED
from drivegate.contracts.current.numbers import FEASIBLE, sensors_of
from drivegate.output.console import console_for
from drivegate.studies.compare.display import show_comparison
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.errors import InputError
from drivegate_reports.comparison.cells import written
from drivegate_reports.comparison.curves import (
    draw_cycle,
    draw_differences,
    draw_over_speed,
    draw_run,
    measured_differences,
)
from drivegate_reports.comparison.inks import inks_of
from drivegate_reports.comparison.maps import candidate_map, draw_map
from drivegate_reports.comparison.report import page, view_of, write
from drivegate_reports.comparison.sheets import table_sheet
from drivegate_reports.page.style import house_style

HOSTILE = (
    "<script>alert(1)</script><img src=x onerror=alert(2)>\"'&{{7*7}}</style>$x^2$\u202e\x00" + "long" * 60
)
NAMES = ("thrifty", "wasteful", "loses")


@pytest.fixture(scope="module")
def document(made_up):
    return json.loads(json.dumps(made_up()))


@pytest.fixture(scope="module")
def text(document):
    return page(document)


def cells(sheet):
    return [[cell.text.replace("\u00a0", " ") for cell in row] for row in sheet.rows]


def test_the_page_begins_with_the_decision(text):
    top = re.sub(r"<[^>]+>|\s+", " ", text[: text.index('id="where"')])
    top = re.sub(r"\s+", " ", top)
    assert "thrifty ranks first" in top
    assert "holds all 16 operating points and takes 50.0 W more than the best possible angle" in top
    assert (
        "wasteful takes 20.0 W more input power (+2.0 %) and 2.00 A more Σ|i| (+6.7 %) over the 16 points"
        in top
    )
    assert "loses takes as much input power and as much Σ|i| over the 12 points that both hold" in top
    assert "but loses 4 of 16 points" in top
    assert "Rule:" in top


def test_the_page_names_the_sensors_that_the_drive_has(document, text, undrawn):
    assert "through the sensors of the published implementation" in text
    document = copy.deepcopy(document)
    document["drive"]["sensors"] = sensors_of(load_drive("star-3-phase"))
    assert "three Hall switches, current sensors, converter with" in view_of(document).method[0]
    del document["drive"]["sensors"]
    assert "through the sensors of the drive" in view_of(document).method[0], (
        "documents of earlier versions tell none"
    )


def test_page_and_terminal_say_which_points_count_and_why_less_than_the_least_is_possible(document):
    stream = io.StringIO()
    show_comparison(console_for(stream), document, ())
    assert f"points and the best possible are of feasible angles: {FEASIBLE}" in stream.getvalue()
    assert table_sheet(document, "ranking").caption.endswith(FEASIBLE)
    gap = next(quantity for quantity in MAPS if quantity.key == "gap_current_percent")
    assert gap.caption.endswith(FEASIBLE), "a gap below zero needs its reason"


def test_ranking_and_regions_say_by_how_much(document):
    ranking = cells(table_sheet(document, "ranking"))
    assert [row[:2] for row in ranking] == [["thrifty", "1"], ["wasteful", "2"], ["loses", "3"]]
    assert ranking[1][4:8] == ["1020.0", "+20.0", "32.00", "+2.00"]
    regions = cells(table_sheet(document, "regions"))
    assert regions[0][1] == "thrifty and loses", "light load at low speed is held by all"
    assert regions[1][1:] == ["thrifty, by 20.0 W", "0.0 W, 0.0 A", "+20.0 W, +2.0 A", "loses 1 of 3"]


def test_differences_come_with_intervals_and_words(document):
    rows = cells(table_sheet(document, "differences"))
    drawn = [row for row in rows if row[0].startswith("drawn") and row[1] == "input power (W)"]
    assert [row[2] for row in drawn] == ["thrifty − wasteful", "thrifty − loses", "wasteful − loses"]
    assert drawn[0][-1] == "thrifty is lower"
    assert drawn[1][-1] == "no real difference"
    low, high = (float(part.replace("−", "-")) for part in drawn[0][4].split(" to "))
    assert -20.3 < low < -20.09 < high < -20.0, "what noise adds to the difference is 0.09 W in the mean"
    cycle = [row for row in rows if row[0].startswith("drive cycle") and row[2] == "thrifty − loses"]
    assert cycle[0][-1] == "too few pairs", "who leaves the cycle has no energy to compare"


def test_figures_show_the_document_s_numbers(document):
    inks = inks_of(document)
    drawn = candidate_map(document, "loses", "gap_power_w")
    assert drawn.lost.sum() == 4
    assert np.isnan(drawn.values[-1]).all(), "points that are not held have no value"
    assert drawn.values[0, 0] == pytest.approx(1000.0 - 950.0), (
        "the optimum at 5 N·m lies between those solved"
    )
    with house_style():
        speed = draw_over_speed(document, inks, (50.0, 100.0), OVER_SPEED.panels)
        line = speed.axes[0].lines[1]
        assert line.get_xdata().tolist() == [550.0, 1000.0, 1500.0, 2000.0]
        assert line.get_ydata().tolist() == [30.0] * 4
        lost = speed.axes[1].lines[-1].get_ydata()
        assert np.isnan(lost).all(), "a lost point is no point of a line"
        panels = measured_differences(document, DIFFERENCES.panels)
        differences = draw_differences(panels, inks)
        mean = differences.axes[0].lines[1].get_xdata()[0]
        assert mean == pytest.approx(-panels[0].rows[0]["mean_difference"])
        assert -panels[0].rows[0]["mean_difference"] > 0.0, "what is drawn is how much more the others take"
        cycle = draw_cycle(document, inks)
        assert cycle.axes[1].lines[1].get_ydata()[-1] == pytest.approx(2.0)
        for figure in (speed, differences, cycle, *(draw_map(document, inks, quantity) for quantity in MAPS)):
            named = [axis for axis in figure.axes if axis.get_visible() and axis.get_xlabel()]
            assert named, "an axis must have a name"
            assert all("(" in axis.get_xlabel() for axis in named), "a name has its unit"


def test_what_is_shown_of_a_disturbance_follows_the_drive(document):
    slow = copy.deepcopy(document)
    slow["drive"].update(change_s=20.0, speed_tolerance_rpm=12.0)
    run = document["trajectories"][0]["run"]
    with house_style():
        shown = [draw_run(made, inks_of(made), run, AFTER_CHANGE.panels).axes for made in (document, slow)]
    assert [axes[-1].get_xlim() for axes in shown] == [(9.0, 16.0), (18.0, 32.0)]
    assert [max(axes[0].get_yticks()) for axes in shown] == [5.0, 12.0], "k1 of the drive"


def test_all_maps_of_a_quantity_share_one_scale(document):
    with house_style():
        figure = draw_map(document, inks_of(document), MAPS[0])
    meshes = [axis.collections[0] for axis in figure.axes[:3]]
    assert len({tuple(mesh.norm.boundaries) for mesh in meshes}) == 1
    contours = figure.axes[0].collections[1]
    np.testing.assert_array_equal(
        contours.levels, meshes[0].norm.boundaries, "contours are the scale's steps"
    )


def test_the_page_is_whole_and_lets_nothing_in(text, document):
    assert "<img" not in text
    assert "<image" not in text, "an image as data would be blocked by the page's own policy"
    assert "://" not in re.sub(r'xmlns(:\w+)?="[^"]*"', "", text)
    assert "default-src &#39;none&#39;" in text
    assert text.count("<svg") == text.count('role="img"') == 9
    labels = re.findall(r'role="img" aria-label="([^"]*)"', text)
    assert all(len(label) > 60 for label in labels), "each figure is described in words"
    assert len(text.encode()) < 3_000_000


@pytest.mark.nightly
def test_the_same_document_gives_the_same_bytes(document, text, tmp_path):
    path = write(copy.deepcopy(document), tmp_path)
    assert path.read_text(encoding="utf-8") == text


def test_hostile_names_stay_text_also_of_candidates_that_fail(made_up):
    document = made_up((HOSTILE, "<b>bold</b>", "$\\frac{a"), faulted=True)
    assert [row["status"] for row in document["tables"]["ranking"]][-2:] == ["faulted", "refused"]
    text = page(document)
    assert "<script>alert" not in text
    assert "<img" not in text
    assert "<b>" not in text
    assert "49" not in re.findall(r"<h1>(.*?)</h1>", text)[0]
    assert "\x00" not in text
    assert "\u202e" not in text
    assert text.count("<script>") == 1, "only the page's own script"
    assert "ValueError: &lt;b&gt;no&lt;/b&gt;" in text
    assert "gone does not exist" in text


@pytest.mark.nightly
def test_a_single_candidate_can_be_reported(made_up):
    view = view_of(made_up(NAMES[:1]))
    assert view.headline == "thrifty ranks first on paper-5-phase, but the checks were not run"
    assert table_sheet(made_up(NAMES[:1]), "differences").rows == ()
    assert measured_differences(made_up(NAMES[:1]), DIFFERENCES.panels) == []


def test_times_are_outside_of_the_hash(document, made_up):
    other = made_up()
    for entry in (document, other):
        assert entry["timing"]["steps"][0]["state_bytes"] == 320
    assert document["provenance"]["content_hash"] == other["provenance"]["content_hash"]
    assert "step_us" not in json.dumps({key: value for key, value in document.items() if key != "timing"})


def test_another_document_is_refused(document):
    with pytest.raises(InputError, match="of kind 'check', but must be of kind 'comparison'"):
        page({"kind": "check"})
    with pytest.raises(InputError, match="schema 99"):
        page({**document, "schema": 99})


def test_numbers_are_written_with_a_real_minus_and_no_negative_zero():
    assert written(-1.25, 1) == "−1.2"
    assert written(-0.0001, 2, signed=True) == "0.00"
    assert written(None, 2) == "–"
    assert math.isclose(float(written(3.14159, 3)), 3.142)
