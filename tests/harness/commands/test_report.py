"""``drivegate report``: the same reports again, and one sentence for what cannot be."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

import drivegate
from drivegate.output.result_reports import OWN_FORMATS

EXAMPLE = Path(__file__).parents[3] / "examples" / "reporter"


@pytest.fixture
def result(command: Any, engine: Any, tmp_path: Path) -> Path:
    """Write a result by the replaced engine."""
    ended = command("check", "reference", "--output", str(tmp_path / "first"))
    assert ended.code == 0, ended.err
    return tmp_path / "first" / "result.json"


def test_reports_are_made_again(command: Any, result: Path, tmp_path: Path) -> None:
    ended = command("report", str(result), "--output", str(tmp_path / "again"), "--json")
    assert ended.code == 0, ended.err
    document = ended.document
    assert (document["kind"], document["verdict"]) == ("reports", "pass")
    assert document["formats"] == ["annotations", "junit", "markdown", "page", "runs"]
    for name in ("result.json", "runs.csv", "junit.xml", "summary.md", "annotations.txt", "report.html"):
        first, again = ((tmp_path / folder / name).read_bytes() for folder in ("first", "again"))
        assert first == again, f"{name} differs"


def test_only_the_reports_that_are_requested(command: Any, result: Path, tmp_path: Path) -> None:
    ended = command("report", str(result), "--format", "markdown", "--output", str(tmp_path / "again"))
    assert ended.code == 0, ended.err
    assert f"report: {tmp_path / 'again' / 'summary.md'}" in ended.out
    assert not (tmp_path / "again" / "report.html").exists()


def test_a_report_that_there_is_not(command: Any, result: Path) -> None:
    ended = command("report", str(result), "--format", "junti")
    assert ended.code == 2
    assert ended.err.strip() == (
        "error: there is no report 'junti', the nearest is 'junit'; there are annotations, junit, markdown, page, runs"
    )


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ({"schema": 1, "kind": "checks", "results": []}, "holds the results of several candidates"),
        ({"schema": 2, "kind": "counterexample"}, "is of kind"),
        ({"schema": 2, "kind": "check"}, "candidate"),
        ({"schema": 3, "kind": "check"}, "is newer than this drivegate reads"),
    ],
)
def test_a_file_that_is_no_result(command: Any, tmp_path: Path, content: dict[str, Any], said: str) -> None:
    file = tmp_path / "result.json"
    file.write_text(json.dumps(content), encoding="utf-8")
    ended = command("report", str(file), "--output", str(tmp_path / "again"))
    assert ended.code == 2
    assert said in ended.err
    assert len(ended.err.splitlines()) == 1
    assert not (tmp_path / "again").exists(), "nothing is written when input is bad"


def test_advisory_checks_can_be_made_to_count(command: Any, engine: Any, tmp_path: Path) -> None:
    command("check", "reference", "--fail-on", "advisory", "--output", str(tmp_path / "report"))
    assert engine.options.fail_on == "advisory"


def test_the_example_of_a_reporter_is_found_by_its_entry_point(result: Path, tmp_path: Path) -> None:
    project = tomllib.loads((EXAMPLE / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    installed = tmp_path / "installed"
    info = installed / f"{project['name'].replace('-', '_')}-{project['version']}.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n"
    )
    points = "".join(
        f"[{group}]\n" + "".join(f"{name} = {place}\n" for name, place in entries.items())
        for group, entries in project["entry-points"].items()
    )
    (info / "entry_points.txt").write_text(points)
    shutil.copy(EXAMPLE / "margin_table.py", installed)
    program = (
        "import sys; sys.path.insert(0, sys.argv.pop(1)); "
        "from drivegate.commands.command_line import main; main()"
    )
    words = ["report", str(result), "--format", "margin-table", "--output", str(tmp_path / "again")]
    ended = subprocess.run(
        [sys.executable, "-c", program, str(installed), *words],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr
    lines = (tmp_path / "again" / "margins.csv").read_text(encoding="utf-8").splitlines()
    assert lines == [
        "candidate,id,level,verdict,margin,runs,measured,limit",
        "reference,CNV-1,required,pass,0.25,1,measured,the limit",
    ]


def test_a_result_of_a_bad_drive_is_refused(command: Any, result: Path) -> None:
    document = json.loads(result.read_text(encoding="utf-8"))
    del document["drive"]["document"]["machine"]["phases"]
    result.write_text(json.dumps(document), encoding="utf-8")
    ended = command("report", str(result))
    assert ended.code == 2
    assert "in the key 'drive.document', the drive: the key 'machine.phases' is missing" in ended.err


def test_no_report_can_be_made_of_an_altered_result(
    command: Any, result: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def written(document: dict[str, Any], folder: Path) -> Path:
        return folder / document["candidate"]["declaration"]["profile"]

    monkeypatch.setitem(OWN_FORMATS, "markdown", written)
    document = json.loads(result.read_text(encoding="utf-8"))
    document["candidate"]["declaration"] = {}
    result.write_text(json.dumps(document), encoding="utf-8")
    ended = command("report", str(result), "--format", "markdown")
    assert ended.code == 2
    assert "result.json was altered after drivegate wrote it" in ended.err
    assert ended.err.strip().endswith("name an unaltered result")


@pytest.fixture
def altered(command: Any, failing: Any, tmp_path: Path) -> Path:
    """Write the result of a candidate that fails, edited so that it passes."""
    failing.faults = ()
    command("check", "reference")
    file = tmp_path / "drivegate-report" / "result.json"
    document = json.loads(file.read_text(encoding="utf-8"))
    document["verdict"], document["exit_code"] = "pass", 0
    document["checks"][0] |= {"verdict": "pass", "margin": 0.9}
    file.write_text(json.dumps(document), encoding="utf-8")
    return file


ALTERED = "was altered after drivegate wrote it: its content is not that of its content hash"


@pytest.mark.parametrize(
    "words",
    [
        ["report", "drivegate-report/result.json", "--output", "again"],
        ["check", "reference", "--last-failed"],
        ["check", "reference", "--baseline", "drivegate-report/result.json", "--output", "again"],
        ["simulate", "reference", "--from", "drivegate-report", "--run", "CUR-1"],
    ],
)
def test_every_command_that_reads_a_result_says_that_it_was_altered(
    command: Any,
    altered: Path,
    caplog: pytest.LogCaptureFixture,
    monkeypatch: pytest.MonkeyPatch,
    words: list[str],
) -> None:
    monkeypatch.setattr("drivegate.studies.simulate.simulated", lambda *_: 1 / 0, raising=False)
    command(*words)
    assert f"result.json {ALTERED}" in caplog.text.replace("\n", " ")


def test_the_pages_of_an_altered_result_say_so(command: Any, altered: Path, tmp_path: Path) -> None:
    ended = command("report", altered, "--output", "again")
    assert ended.code == 0
    assert f"reference: pass, but the result {ALTERED}" in " ".join(ended.out.split())
    for name in ("summary.md", "junit.xml", "annotations.txt"):
        text = (tmp_path / "again" / name).read_text(encoding="utf-8")
        assert "was altered after drivegate wrote it" in text, name
    assert not (tmp_path / "again" / "junit.xml").read_text(encoding="utf-8").count('errors="0"')


def test_the_seams_where_results_are_read_are_few() -> None:
    """Whatever reads a result goes through the module that verifies its hash."""
    package = Path(drivegate.__file__).parent
    readers = {
        str(file.relative_to(package))
        for file in package.rglob("*.py")
        if 'require_kind(mapping, "check"' in file.read_text(encoding="utf-8")
    }
    assert readers == {"results/stored.py"}
