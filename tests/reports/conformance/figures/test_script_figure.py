"""The figure of a script: a counterexample without a plant is shown as what the controller sensed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from drivegate_cases.documents.document import parse_document
from drivegate_cases.scenario.script import Script
from drivegate_reports.conformance.figures import script as script_figure
from drivegate_reports.conformance.report import page
from drivegate_reports.conformance.runs import shown_runs
from drivegate_reports.page.style import house_style

Factory = Callable[..., dict[str, Any]]
ROWS = [
    {"speed_reference_rpm": 1500.0, "speed_rpm": speed, "current_sum_a": current, "supply_v": 48.0}
    for speed, current in ((1500.0, 40.0), (1499.0, 39.5), (1490.0, 41.25))
]
STORED = {"schema": 1, "kind": "script", "name": "falling <b>", "drive": "paper-5-phase", "rows": ROWS}
MEASURED = "row 3, at 0.3 s: the angle is -2° from the initial one, but Fig. 4 has -1°"


@pytest.fixture
def document(make_document: Factory, make_check: Factory) -> dict[str, Any]:
    failed = make_check(
        "FLO-1", verdict="fail", margin=-1.0, measured=MEASURED, scenario=STORED, counterexample=STORED
    )
    return make_document(verdict="fail", exit_code=1, checks=[failed])


def test_the_figure_has_a_step_for_every_row_in_its_units() -> None:
    with house_style():
        figure = script_figure.draw(parse_document(STORED, Script, "the script"))
    speed, current = figure.axes
    for panel, key in ((speed, "speed_rpm"), (current, "current_sum_a")):
        values, edges, _ = panel.patches[-1].get_data()  # type: ignore[attr-defined]
        assert list(values) == [row[key] for row in ROWS], f"{key} is drawn as {values}"
        assert list(edges) == [0.5, 1.5, 2.5, 3.5], "a row is one unit wide, from number 1 on"
    assert (speed.get_ylabel(), current.get_ylabel()) == ("speed (rpm)", "current (A)")
    assert current.get_xlabel() == "row (periods of the search)"


def test_words_for_the_figure_have_its_numbers() -> None:
    words = script_figure.alternative(parse_document(STORED, Script, "the script"))
    assert "3 rows" in words
    assert "-10 to +0 rpm off its reference" in words
    assert "from 40 A to 41.25 A, at least 39.5 A" in words


def test_a_script_that_fails_is_shown_and_reported(document: dict[str, Any]) -> None:
    (shown,) = shown_runs(document).values()
    assert shown.account == (f"Script of 3 rows, each held for one period of the search: {MEASURED}.",)
    text = page(document)
    assert 'id="script-FLO-1"' in text
    assert "Script falling &lt;b&gt;" in text
    assert MEASURED in text


def test_what_is_no_script_is_left_out(document: dict[str, Any]) -> None:
    document["checks"][0]["counterexample"] = {"kind": "script", "rows": "none"}
    assert shown_runs(document) == {}
