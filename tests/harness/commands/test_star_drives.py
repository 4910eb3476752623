"""Commands on a star, from end to end: what they find, and that nothing they say is of the 5-phase drive."""

import html
import json
import re
from pathlib import Path

import pandas
import pytest

from drivegate.contracts.current.comparison import plan as comparison_plan
from drivegate_cases.scenario.scenario import load_scenario

STAR = ("--drive", "star-3-phase", "--workers", 1)
AT_FULL_LOAD = comparison_plan.ComparisonEffort((1.0,), (1.0,), 0, 1, 1)
CYCLE = "time_s,speed_km_h\n0,0\n1,0\n3,15\n4,15\n5,12\n6,12\n"
OF_THE_PAPER_S_DRIVE = re.compile(
    r"encoder|published implementation|unequal halves|\b5-phase|five phases|\b26 A\b"
)


def words_of(page: Path) -> str:
    """Give what a page says, without its markup, drawings and scripts."""
    text = page.read_text(encoding="utf-8")
    text = re.sub(r"<(head|script|style|svg)\b.*?</\1>", " ", text, flags=re.DOTALL)
    return " ".join(html.unescape(re.sub(r"<[^>]+>", " ", text)).split())


def test_a_comparison_is_made_through_the_star_s_own_sensors(command, monkeypatch, tmp_path):
    monkeypatch.setitem(comparison_plan.EFFORTS, "quick", AT_FULL_LOAD)
    # The page is a function of the document, and its figures take longer than the runs.
    monkeypatch.setattr("drivegate.output.report_writers.entry_points", lambda group: [])
    (tmp_path / "short.csv").write_text(CYCLE, encoding="utf-8")
    size = ("--effort", "quick", "--cycle", "short.csv", "--no-checks")
    ended = command("compare", "reference", *STAR, *size, "--output", "out", "--json")
    assert ended.code == 0, ended.err
    tables = ended.document["tables"]
    (found,) = tables["operating_points"]
    assert found["held"]
    # At full load the least Σ|i| lies on the edge, which is at 70.9°.
    (best,) = tables["best_possible"]
    assert best["edge_deg"] == pytest.approx(70.9, abs=0.1)
    assert -0.5 < found["above_edge_deg"] < 1.0
    assert found["gap_current_percent"] < 2.0
    assert "three Hall switches" in ended.document["drive"]["sensors"]


def test_a_campaign_judges_the_neutral_and_finds_the_lock_up(command, tmp_path):
    short = load_scenario("lock-up").replaced(name="short", duration_s=11.2)
    (tmp_path / "short.json").write_text(short.to_json(), encoding="utf-8")
    plan = {
        "schema": 1,
        "name": "star",
        "candidates": ["published"],
        "cases": ["short.json"],
        "draws": 1,
        "spread": {"resistance": {"kind": "uniform", "lowest": 0.95, "highest": 1.05}},
    }
    (tmp_path / "plan.json").write_text(json.dumps(plan), encoding="utf-8")
    ended = command("campaign", "plan.json", *STAR, "--output", "out", "--json")
    assert ended.code == 0, ended.err
    (published,) = ended.document["candidates"]
    checks = {check["id"]: check for check in published["checks"]}
    assert checks["NEU-1"]["violations"] == 0
    assert checks["ROB-1"]["violations"] == 1, "Fig. 4 taken literally locks up on a star too"
    words = words_of(tmp_path / "out" / "campaign.html")
    assert "phase currents of a star sum to zero" in words
    assert not (said := OF_THE_PAPER_S_DRIVE.findall(words)), said


def test_a_map_of_a_star_is_its_oracle_s(command, tmp_path):
    axes = ("--speed-rpm", "1500", "--torque-nm", "9.55")
    ended = command("map", "reference", *STAR, *axes, "--csv", "map.csv", "--plot", "map.svg", "--json")
    assert ended.code == 0, ended.err
    row = pandas.read_csv(tmp_path / "map.csv").iloc[0]
    assert row["verdict"] == "converged"
    assert row["least_current_sum_a"] == pytest.approx(47.9, abs=0.1)
    # It rests at the least itself, so rounding may put it below.
    assert -1e-3 <= row["excess_percent"] < 2.0
    assert "<svg" in (tmp_path / "map.svg").read_text(encoding="utf-8")
