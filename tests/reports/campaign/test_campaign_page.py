"""The page of a campaign: probabilities with intervals, distributions, worst runs, and nothing of a candidate acts."""

from __future__ import annotations

import re
from html import unescape
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drivegate_models.errors import InputError
from drivegate_reports.campaign.distributions import CheckDistribution, alternative, draw
from drivegate_reports.campaign.report import REPORT_FILE, page, view_of, write
from drivegate_reports.page.style import house_style

Document = dict[str, Any]


def commands(text: str) -> list[str]:
    return [unescape(command) for command in re.findall(r"<code>(drivegate .*?)</code>", text)]


def test_each_check_has_its_probability_with_the_interval(campaign_document: Document) -> None:
    rows = {row.name: row for row in view_of(campaign_document).candidates[0].rows}
    broken = rows["ROB-1"]
    assert (broken.share, broken.probability, broken.interval) == ("3 of 4", "0.75", "0.194 to 0.994")
    assert (broken.low, broken.high, broken.at) == pytest.approx((19.4, 99.4, 75.0)), "the bar shows the same"
    assert broken.margins == ("−44", "−44", "−1.5"), "least, 5 % and median"
    assert rows["any"].tone == "fail"
    assert rows["PWR-1"].tone == "pass"


def by_point(stated: Document, case: str = "fig5-search") -> Document:
    """Return a share as a campaign states it whose runs were chosen at two points."""
    first = stated | {"case": case, "parameters": {"load_share": 0.5}}
    second = first | {
        "parameters": {"load_share": 1.0},
        "violations": 0,
        "probability": 0.0,
        "interval": [0.0, 0.6],
    }
    several = {"probability": None, "interval": None, "points": [first, second]}
    return stated | {"runs": 2 * stated["runs"]} | several


@pytest.mark.nightly
def test_each_point_that_was_chosen_has_a_row_and_all_have_no_interval(campaign_document: Document) -> None:
    candidate = campaign_document["candidates"][0]
    candidate["not_passed"] = by_point(candidate["not_passed"])
    rows = view_of(campaign_document).candidates[0].rows[:3]
    assert [(row.requirement, row.share, row.interval) for row in rows] == [
        (rows[0].requirement, "3 of 8", "–"),
        ("load_share 0.5", "3 of 4", "0.194 to 0.994"),
        ("load_share 1", "0 of 4", "0 to 0.6"),
    ]
    assert "differs from point to point" in view_of(campaign_document).candidates[0].sentence


def test_the_worst_runs_come_with_commands_and_those_that_fail_come_first(
    campaign_document: Document,
) -> None:
    worst = view_of(campaign_document).candidates[0].worst
    assert worst[0].command == (
        "drivegate replay counterexamples/mine/ROB-1.json --candidate '/home/mine/my drives/mine.py:Mine'"
    )
    assert worst[0].facts == "fig5-search; load_share 0.5; resistance 1.01013; friction_added_n_m 0.178147"
    assert worst[1].command == (
        "drivegate simulate '/home/mine/my drives/mine.py:Mine' --case worst/run-000003.json"
    ), "a check that is met has no counterexample, but a run"
    assert set(commands(page(campaign_document))) >= {row.command for row in worst}


def test_a_fault_stands_before_the_checks(campaign_document: Document) -> None:
    fault = {"verdict": "crash", "run": 2, "file": "faults/mine/crash.json"}
    campaign_document["candidates"][0]["first_faults"] = [fault]
    first = view_of(campaign_document).candidates[0].worst[0]
    assert (first.what, first.run) == ("crash", "2")
    assert first.command.endswith("--case faults/mine/crash.json")


def test_nothing_of_a_candidate_acts_on_the_page(campaign_document: Document) -> None:
    hostile = "<script>alert(1)</script>\x1b[31m"
    candidate = campaign_document["candidates"][0]
    candidate["name"] = hostile
    candidate["not_passed"] = by_point(candidate["not_passed"], hostile)
    candidate["checks"][0] |= {"worst_measured": hostile, "worst_case": hostile}
    candidate["first_faults"] = [{"verdict": hostile, "run": 0, "file": hostile}]
    campaign_document |= {"campaign": hostile, "specifications": [hostile, "reference"]}
    text = page(campaign_document)
    assert "<script>alert" not in text
    assert "\x1b" not in text
    assert text.count("<script>") == 1, "the script of every page, and no other"


@pytest.mark.nightly
def test_the_same_summary_gives_the_same_bytes(campaign_document: Document, tmp_path: Path) -> None:
    path = write(campaign_document, tmp_path)
    assert path == tmp_path / REPORT_FILE
    before = path.read_bytes()
    assert write(campaign_document, tmp_path).read_bytes() == before


def test_the_curve_is_the_share_of_runs_with_at_most_that_margin() -> None:
    row = CheckDistribution("ROB-1", np.array([-np.inf, -0.5, 0.25, 3.0]), "2 of 4")
    with house_style():
        (panel,) = draw([row]).axes
    _, below, above = panel.get_lines()
    assert below.get_xydata()[1:-1].tolist() == [[-1.0, 0.25], [-0.5, 0.5]], "beyond the axis at its border"
    assert below.get_xydata()[-1].tolist() == [0.0, 0.5], "at zero it is the share of violations"
    assert above.get_xydata()[1:-1].tolist() == [[0.25, 0.75], [1.0, 1.0]]
    assert panel.get_title(loc="left") == "ROB-1: 2 of 4 violated"
    assert "ROB-1: least −inf, median −0.5" in alternative([row])


@pytest.mark.nightly
def test_a_check_that_never_decides_and_a_candidate_without_runs_are_reported(
    campaign_document: Document,
) -> None:
    nothing = {"violations": 0, "runs": 0, "probability": None, "interval": [0.0, 1.0]}
    never = campaign_document["candidates"][0]["checks"][0] | nothing | {"advisory_runs": 4}
    never |= {"margins": [], "margin_quantiles": [], "worst_run": None, "worst_margin": None}
    never |= {"counterexample": None, "worst_scenario": None, "worst_measured": None}
    empty = {"checks": [never], "not_passed": nothing, "verdicts": {"set aside": 4}}
    campaign_document["candidates"][0] |= empty
    candidate = view_of(campaign_document).candidates[0]
    assert candidate.sentence == "No run says anything about this candidate."
    assert candidate.figure is None
    assert (candidate.rows[1].share, candidate.rows[1].probability) == ("–", "–")
    assert candidate.rows[1].level == "required, advises alone in 4 runs"
    assert "PWR-1" in page(campaign_document)


@pytest.mark.parametrize(
    ("change", "reason"), [({"kind": "check"}, "of kind 'check'"), ({"schema": 99}, "schema 99")]
)
def test_another_document_is_refused(campaign_document: Document, change: Document, reason: str) -> None:
    with pytest.raises(InputError, match=reason):
        page(campaign_document | change)
