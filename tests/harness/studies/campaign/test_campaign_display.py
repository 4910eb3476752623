"""A finished campaign on the console: tables that fit, a page to open, and a command that works as printed."""

from __future__ import annotations

import io
from typing import Any

import pytest
from rich.console import Console

from drivegate.studies.campaign.display import probability_text, show_campaign, shown_margins


def shown(document: dict[str, Any], width: int = 160) -> list[str]:
    stream = io.StringIO()
    show_campaign(Console(file=stream, width=width, markup=False, soft_wrap=True, highlight=False), document)
    return stream.getvalue().splitlines()


@pytest.fixture
def document() -> dict[str, Any]:
    counted = {"violations": 123, "runs": 4000, "probability": 0.03075, "interval": [0.0256, 0.0366]}
    check = {
        "id": "CNV-1",
        "level": "required",
        "counterexample": "counterexamples/mine/CNV-1.json",
        "margin_quantiles": [-44.037, -38.101, 0.5],
        "worst_run": 3999,
        **counted,
    }
    mine = {
        "name": "mine",
        "verdicts": {"fail": 123, "pass": 3877},
        "checks": [check, check | {"id": "CUR-1", "level": "advisory", "counterexample": None}],
        "not_passed": counted,
        "first_faults": [],
    }
    return {
        "confidence": 0.95,
        "quantiles": [0.0, 0.05, 0.5],
        "output": "my campaign",
        "pages": ["my campaign/campaign.html"],
        "specifications": ["sub folder/mine.py:Mine"],
        "candidates": [mine],
    }


def test_the_next_step_names_page_and_candidate_and_is_not_wrapped(document):
    lines = shown(document, 60)
    assert lines[-2].startswith("next: my campaign/campaign.html has the margins of all runs")
    assert lines[-1] == (
        "next: drivegate replay 'my campaign/counterexamples/mine/CNV-1.json' "
        "--candidate 'sub folder/mine.py:Mine'"
    ), "without --candidate, replay refuses a candidate that does not come with drivegate"


@pytest.mark.parametrize("width", [60, 80, 100, 160])
def test_no_column_is_wrapped_within_its_words(document, width):
    lines = shown(document, width)
    table = lines[1 : next(place for place, line in enumerate(lines) if line.startswith("results:"))]
    assert max(map(len, table)) <= width
    assert [line.split()[0] for line in table if line.strip()[:1].isalpha()] == [
        "check",
        "CNV-1",
        "CUR-1",
        "any",
    ]
    (row,) = [line for line in table if "CNV-1" in line]
    for cell in ("123 of 4000", "0.0256 to 0.0366", "-44.037"):
        assert cell in row, "how often, how likely and how bad fit every console"


def test_wide_consoles_show_all_columns(document):
    head = next(line for line in shown(document, 160) if "check" in line)
    assert " ".join(head.split()) == (
        "check level violated probability 95 % interval worst margin 5 % median worst run"
    )


def test_points_that_were_chosen_have_rows_of_their_own_and_no_common_interval(document):
    point = {"case": "start", "violations": 0, "runs": 8, "probability": 0.0, "interval": [0.0, 0.3694]}
    low, high = ({"parameters": {"load_share": share}} for share in (0.5, 1.0))
    failing = point | high | {"violations": 8, "probability": 1.0, "interval": [0.6306, 1.0]}
    together = {"violations": 8, "runs": 16, "probability": None, "interval": None}
    (mine,) = document["candidates"]
    mine["checks"][0] |= together | {"points": [point | low, failing]}
    mine["checks"][1] |= together | {"violations": 0, "points": [point | low, point | high]}
    rows = [" ".join(line.split()) for line in shown(document)]
    assert "CNV-1 required 8 of 16 – – -44.037 -38.101 0.500 3999" in rows
    assert "load_share 0.5 0 of 8 0 0 to 0.369" in rows
    assert "load_share 1 8 of 8 1 0.631 to 1" in rows
    (met,) = (row for row in rows if row.startswith("CUR-1"))
    assert met.startswith("CUR-1 advisory 0 of 16 – 0 to 0.369 at each point"), "one row says it of all"


@pytest.mark.parametrize(
    ("value", "text"), [(None, "–"), (0.0, "0"), (1.0, "1"), (0.36941665, "0.369"), (3.689e-7, "0.000000369")]
)
def test_a_probability_is_not_written_in_powers_of_ten(value, text):
    assert probability_text(value) == text


def test_the_margins_that_are_reported_are_found_by_their_shares_of_the_runs():
    shares = [0.0, 0.01, 0.05, 0.5, 1.0]
    assert shown_margins(shares, {"margin_quantiles": [-4.0, -3.0, -2.0, 1.0, 9.0]}) == (-4.0, -2.0, 1.0)
    assert shown_margins(shares, {"margin_quantiles": []}) == (None, None, None), "a check without runs"
