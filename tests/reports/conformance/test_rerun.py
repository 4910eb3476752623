"""The commands of a page and a summary run in the folder that they name, as they are printed."""

from __future__ import annotations

import json
import re
import shlex
from html import unescape
from pathlib import Path
from typing import Any

import pytest
from tests.harness.ended import ended
from tests.harness.made import made_outcome, made_result, with_hash

from drivegate.candidates.resolution import resolve_candidate
from drivegate.output.continuous_integration import markdown
from drivegate.output.rerun import moved_to, places_of, replay_command
from drivegate.output.result_file import write_result_files
from drivegate_cases.scenario.scenario import load_scenario
from drivegate_reports.conformance.report import page

CONTROLLER = """
from drivegate import Command

class Mine:
    def reset(self, nameplate): pass
    def step(self, sense): return Command(current_reference=5.0, advance_angle=2.0)
"""


@pytest.fixture
def report(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Write the report of a check that ran in another folder, on a candidate whose file lies there."""
    working = tmp_path / "my project"
    (working / "src").mkdir(parents=True)
    (working / "src" / "mine.py").write_text(CONTROLLER, encoding="utf-8")
    monkeypatch.chdir(working)
    scenario = load_scenario("lock-up").replaced(
        duration_s=1.0, initial_speed_rpm=500.0, speed_rpm=((0.0, 500.0),)
    )
    failed = made_outcome(
        "ADV-2", "fail", margin=-1.0, counterexample=scenario.to_mapping(), scenario=scenario.to_mapping()
    )
    result = made_result(resolve_candidate("src/mine.py:Mine"), checks=(failed,), verdict="fail", exit_code=1)
    folder = working / "out" / "a report"
    folder.mkdir(parents=True)
    document = result.written()
    document["timing"]["places"] = places_of(folder)
    write_result_files(document, folder)
    (folder / "summary.md").write_text(markdown(document), encoding="utf-8")
    (folder / "report.html").write_text(page(document), encoding="utf-8")
    return folder


def commands_of(folder: Path) -> set[str]:
    shown = re.findall(
        r'<code class="command">((?:cd|drivegate) .*?)</code>',
        (folder / "report.html").read_text(encoding="utf-8"),
    )
    summary = (folder / "summary.md").read_text(encoding="utf-8")
    return {*map(unescape, shown), *re.findall(r"^    (.*drivegate replay .*)$", summary, re.MULTILINE)}


def carried_out(command: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> Any:
    """Carry out a command as a shell does that is in a folder."""
    monkeypatch.chdir(folder)
    change, _, words = command.rpartition(" && ")
    if change:
        monkeypatch.chdir(Path(shlex.split(change)[1]))
    return ended(capsys, *shlex.split(words)[1:])


def test_every_replay_command_works_from_the_folder_of_the_page(
    report: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    commands = [command for command in commands_of(report) if " replay " in command]
    assert len(commands) == 2, "with a plot on the page, without one in the summary"
    for command in commands:
        again = carried_out(command, report, monkeypatch, capsys)
        assert (again.code, again.out.split()[:3]) == (1, ["ADV-2", "STILL", "FAILS"]), again.err


def test_reports_that_are_made_again_elsewhere_have_commands_that_work_there(
    report: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    made = ended(capsys, "report", report / "result.json", "--output", "again", "--format", "markdown")
    assert made.code == 0, made.err
    assert (tmp_path / "again" / "result.json").read_bytes() == (report / "result.json").read_bytes()
    summary = (tmp_path / "again" / "summary.md").read_text(encoding="utf-8")
    (command,) = re.findall(r"^    (.*drivegate replay .*)$", summary, re.MULTILINE)
    again = carried_out(command, tmp_path / "again", monkeypatch, capsys)
    assert (again.code, again.out.split()[0]) == (1, "ADV-2"), again.err


def test_a_result_without_places_and_a_name_that_is_no_path_need_no_change_of_folder(tmp_path: Path) -> None:
    document = with_hash(
        {"candidate": {"specification": "foc", "kind": "builtin"}, "faults": [], "timing": {}}
    )
    assert replay_command(document, "STP-1") == "drivegate replay counterexamples/STP-1.json --candidate foc"
    placed = json.loads(json.dumps(document | {"timing": {"places": places_of(tmp_path)}}))
    assert replay_command(placed, "STP-1") == replay_command(document, "STP-1")
    assert moved_to(document, tmp_path / "result.json", tmp_path)["timing"] == {}
