"""The page that compares drives, from a document made up for it."""

import copy
import io
import json
import re

import numpy as np
import pytest

from drivegate.output.console import console_for
from drivegate.studies.compare.display import show_comparison
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.errors import InputError
from drivegate_reports.comparison.drive_curves import draw_full_load, draw_greatest_power
from drivegate_reports.comparison.drive_report import drive_view_of, page, write
from drivegate_reports.page.style import house_style

HOSTILE = "<script>alert(1)</script><img src=x onerror=alert(2)>\"'&{{7*7}}</style>$x^2$\u202e\x00"


@pytest.fixture(scope="module")
def document(made_up_drives):
    return json.loads(json.dumps(made_up_drives()))


@pytest.fixture(scope="module")
def text(document):
    return page(document)


def test_the_page_begins_with_what_differs_under_each_controller(text):
    top = re.sub(r"<[^>]+>|\s+", " ", text[: text.index('id="summary"')])
    assert "paper-5-phase and fan-3-phase under the same controllers" in top
    # Σ|i| of 30 A is 30/(5·26) of one drive and 30/(3·6.9) of the other.
    assert "Σ|i| (pu) paper-5-phase 0.231, fan-3-phase 1.449" in top
    assert "Per unit (pu): speed over base speed" in top
    assert 'href="drive-1/comparison.html"' in text
    assert 'href="drive-2/comparison.html"' in text


def test_a_candidate_is_compared_over_the_points_that_it_holds_on_every_drive(document):
    shared = {row["candidate"]: row["points_shared"] for row in document["tables"]["summary"]}
    assert shared == {"thrifty": 16, "wasteful": 16, "loses": 12}, "full load is lost on both"
    sheets = {section.name: section.sheet for section in drive_view_of(document).sections}
    rows = {row[0].text: [cell.text for cell in row] for row in sheets["summary"].rows}
    assert rows["loses"][4:6] == ["12 of 16", "12"]
    assert rows["loses"][-2:] == ["–", "–"], "rated power was held nowhere"
    assert [row[-2].text for row in sheets["drives"].rows] == ["4.00", "4.00"]


def test_figures_show_the_document_s_numbers(document):
    with house_style():
        figure = draw_full_load(document, (("current_sum_pu", "Σ|i| (pu)"), ("ripple_percent", "ripple (%)")))
        power = draw_greatest_power(document)
    paper, fan = (figure.axes[0].lines[place] for place in (0, 1))
    assert paper.get_xdata().tolist() == [1.1, 2.0, 3.0, 4.0]
    assert paper.get_ydata().tolist() == pytest.approx([30.0 / 130.0] * 4)
    assert fan.get_ydata().tolist() == pytest.approx([30.0 / 20.7] * 4)
    assert np.isnan(figure.axes[0].lines[-1].get_ydata()).all(), "a lost point is no point of a line"
    assert min(power.axes[0].lines[1].get_ydata()) >= 1.0, (
        "the drive of the paper gives rated power throughout"
    )


def test_the_page_is_whole_and_lets_nothing_in(text):
    assert "<img" not in text
    assert "://" not in re.sub(r'xmlns(:\w+)?="[^"]*"', "", text)
    assert "default-src &#39;none&#39;" in text
    assert text.count("<svg") == text.count('role="img"') == 3
    assert all(len(words) > 60 for words in re.findall(r'role="img" aria-label="([^"]*)"', text))


def test_the_same_document_gives_the_same_bytes(document, text, tmp_path):
    path = write(copy.deepcopy(document), tmp_path)
    assert path.read_text(encoding="utf-8") == text


def test_hostile_names_of_candidates_and_drives_stay_text(made_up_drives):
    drives = (load_drive("paper-5-phase").replaced(name="<b>mine</b>"), load_drive("fan-3-phase"))
    document = made_up_drives((HOSTILE, "<b>bold</b>", "$\\frac{a"), drives=drives, faulted=True)
    text = page(document)
    assert "<script>alert" not in text
    assert "<img" not in text
    assert "<b>" not in text
    assert "49</style>" not in text
    assert "\x00" not in text
    assert "\u202e" not in text
    assert text.count("<script>") == 1, "only the page's own script"
    assert "ValueError: &lt;b&gt;no&lt;/b&gt;" in text
    assert "gone does not exist" in text
    stream = io.StringIO()
    show_comparison(console_for(stream), document, ())
    assert "\u202e" not in stream.getvalue()
    assert "broken on fan-3-phase: exception" in stream.getvalue()
    assert "Per unit (pu): speed over base speed" in stream.getvalue()
    assert "fan-3-phase: rated power up to 4.00 pu of base speed" in stream.getvalue()


def test_another_document_is_refused(document):
    with pytest.raises(InputError, match="of kind 'comparison', but must be of kind 'drive-comparison'"):
        page({"kind": "comparison"})
    with pytest.raises(InputError, match="schema 99"):
        page({**document, "schema": 99})


def test_times_are_outside_of_the_hash(document, made_up_drives):
    other = made_up_drives()
    other["parts"][0]["timing"]["seconds"] = 99.0
    assert document["provenance"]["content_hash"] == other["provenance"]["content_hash"]
