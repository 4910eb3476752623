"""A contract in a folder of its own is checked, compared step by step and in figures, and run in campaigns.

It is entered into the tables of a process of its own, so that no other test meets it.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[3]
FOLDER = ROOT / "tests" / "toy_contract"
LATE_S = 0.2

Answer = Callable[..., tuple[int, dict[str, Any]]]


@pytest.fixture
def answer(tmp_path: Path) -> Answer:
    """Run a command that knows the contract, and return its exit code and document."""

    def run(*words: object) -> tuple[int, dict[str, Any]]:
        command = [sys.executable, "-m", "tests.toy_contract", *map(str, words), "--json"]
        places = os.pathsep.join((str(ROOT), os.environ.get("PYTHONPATH", "")))
        environment = os.environ | {"PYTHONPATH": places}
        ended = subprocess.run(
            command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
        )
        assert ended.stdout, ended.stderr
        return ended.returncode, json.loads(ended.stdout)

    return run


@pytest.mark.nightly
def test_a_good_controller_passes_and_a_weak_one_is_caught_with_a_witness(answer: Answer) -> None:
    quick = ("--effort", "quick", "--workers", "1")
    code, passed = answer("check", "toy:good", *quick)
    assert (passed["verdict"], code) == ("pass", 0)
    code, caught = answer("check", "toy:weak", *quick)
    assert code == 1
    assert [(check["id"], check["verdict"], check["witness"]["name"]) for check in caught["checks"]] == [
        ("TOY-1", "fail", "toy:good")
    ]


@pytest.mark.nightly
def test_the_first_different_step_is_found(answer: Answer) -> None:
    case = ("--case", FOLDER / "toy-case.json")
    assert answer("diff", "toy:good", "toy:good", *case)[1]["verdict"] == "equal"
    found = answer("diff", "toy:good", "toy:late", *case)[1]["difference"]
    assert found["time_s"] == pytest.approx(LATE_S)
    (field,) = found["commands"]
    assert (field["field"], field["unit"], field["difference"]) == ("voltage", "V", pytest.approx(0.125))


@pytest.mark.nightly
def test_controllers_are_ranked_by_the_figures_of_their_contract(answer: Answer) -> None:
    words = ("compare", "toy:weak", "toy:good", "--effort", "quick", "--no-checks", "--workers", "1")
    _, document = answer(*words)
    assert document["kind"] == "toy-comparison"
    assert [row["candidate"] for row in document["tables"]["ranking"]] == ["toy:good", "toy:weak"]


@pytest.mark.nightly
def test_a_campaign_keeps_what_the_contract_observes(answer: Answer, tmp_path: Path) -> None:
    code, document = answer("campaign", FOLDER / "toy-campaign.toml", "--output", "out", "--workers", "1")
    assert (code, document["candidates"][0]["verdicts"]) == (0, {"pass": 2})
    files = list((tmp_path / "out").rglob("*.parquet"))
    assert files
    assert all(b"speed_error_rpm" in file.read_bytes() for file in files), "the observed figures are columns"
