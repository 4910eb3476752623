"""`drivegate check`: verdicts, exit codes, the files of the report, and candidates beside each other."""

import json
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import pytest
from tests.harness.commands.conftest import OnePage, outcome

from drivegate.candidates.fault import Fault, FaultKind
from drivegate.gate.options import CheckOptions
from drivegate.results.document import WitnessedSection
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.errors import HarnessFault, InputError

FILES = [
    ".drivegate-report.json",
    "annotations.txt",
    "junit.xml",
    "report.html",
    "result.json",
    "runs.csv",
    "summary.md",
]


USUAL = CheckOptions()


def names(folder):
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def test_a_pass_is_reported_and_reported(command, engine, tmp_path):
    ended = command(
        "check", "reference", "--effort", "quick", "--seed", "7", "--workers", "1", "--max-time", "9"
    )
    assert ended.code == 0
    requested = {"effort": "quick", "seed": 7, "workers": 1, "max_time": 9.0}
    given = replace(engine.options, on_slow=None, is_ended=USUAL.is_ended)
    assert given == replace(USUAL, **requested)
    assert "reference: pass" in ended.out
    assert "report: drivegate-report/report.html" in ended.out
    assert "a report that prints" not in ended.out
    assert ended.err.splitlines()[0] == (
        "reference on paper-5-phase (default for current-reference candidates), contract current, effort quick, seed 0"
    )
    assert names(tmp_path / "drivegate-report") == FILES


def test_json_is_the_result_document(command, engine, tmp_path):
    ended = command("check", "reference", "--json")
    document = ended.document
    keys = {"schema", "candidate", "verdict", "exit_code", "seed", "checks", "provenance"}
    assert set(document) >= keys
    assert set(document["checks"][0]) >= {
        "id", "level", "verdict", "margin", "runs", "message", "counterexample",
    }  # fmt: skip
    paper = load_drive("paper-5-phase")
    assert document["drive"] == {
        **paper.identity(), "specification": None, "document": paper.to_mapping()
    }  # fmt: skip
    stored = json.loads((tmp_path / "drivegate-report" / "result.json").read_text(encoding="utf-8"))
    assert stored == document


def test_a_failure_names_the_counterexample_its_file_and_the_next_step(command, failing, tmp_path):
    ended = command("check", "reference", "--output", "out")
    assert ended.code == 1
    assert "CNV-1 fails (required)" in ended.out
    assert "lock-up: 20 s, 1500 rpm, load constant torque 9.8 N·m × 0 → 1" in ended.out
    assert "facts for 20 s, constant torque 9.8 N·m" in ended.out
    assert (
        "next: drivegate replay out/counterexamples/CNV-1.json --candidate reference --plot CNV-1.svg"
        in ended.out
    )
    assert "exception in 2 runs" in ended.out
    file = json.loads((tmp_path / "out" / "counterexamples" / "CNV-1.json").read_text(encoding="utf-8"))
    assert (file["schema"], file["check"], file["margin"], file["seed"]) == (2, "CNV-1", -1.5, 0)
    assert set(file["candidate"]) == {"name", "hash"}
    assert file["versions"]["drivegate"]
    assert file["drive"] == load_drive("paper-5-phase").identity()
    assert file["scenario"]["drive"]["machine"]["pole_pairs"] == 11, "the scenario must be fully resolved"


def test_a_narrow_terminal_breaks_no_command_that_is_to_be_copied(command, failing, monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    lines = command("check", "reference", "--output", "a-folder-with-a-rather-long-name").out.splitlines()
    following = next(line for line in lines if line.startswith("next: "))
    assert following.endswith(
        "a-folder-with-a-rather-long-name/counterexamples/CNV-1.json --candidate reference --plot CNV-1.svg"
    )
    assert max(len(line) for line in lines if line.startswith(" CNV-1")) <= 60, "tables must fit"


def test_nothing_that_a_candidate_says_acts_on_terminal_xml_or_markdown(command, failing, tmp_path):
    ended = command("check", "reference")
    for text in (ended.out, ended.err):
        assert "\x1b" not in text
        assert "\x07" not in text
        assert "\u202e" not in text
    assert "[red]markup[/red]" in ended.out, "markup must be shown as it is"
    folder = tmp_path / "drivegate-report"
    summary = (folder / "summary.md").read_text(encoding="utf-8")
    assert "<script>" not in summary.replace("\\<script\\>", "")
    rows = [line for line in summary.splitlines() if line.startswith("| CNV-1")]
    assert rows[0].replace("\\|", "").count("|") == 6, "a message must not break the table"
    cases = {case.get("name"): case for case in ElementTree.parse(folder / "junit.xml").iter("testcase")}
    assert "<script>" in cases["CNV-1"].find("failure").get("message")


def test_junit_counts_what_a_ci_server_counts(command, failing, tmp_path):
    command("check", "reference")
    suite = ElementTree.parse(tmp_path / "drivegate-report" / "junit.xml").getroot().find("testsuite")
    counts = {key: suite.get(key) for key in ("tests", "failures", "errors", "skipped")}
    # Six cases: five checks and one fault that came twice; an advisory check that fails does not count.
    assert counts == {"tests": "6", "failures": "1", "errors": "2", "skipped": "1"}


def test_several_candidates_get_a_folder_each_and_a_refused_one_stops_nobody(command, failing, tmp_path):
    ended = command("check", "reference", "nobody", "initial", "--output", "out", "--json")
    assert ended.code == ended.document["exit_code"] == 2, "a refusal wins over a failure"
    first, second, third = ended.document["results"]
    assert (first["verdict"], third["verdict"]) == ("exception", "exception")
    assert second["error"]["exit_code"] == 2
    assert second["candidate"] == {"specification": "nobody"}
    assert "error: nobody: the candidate 'nobody' is unknown" in ended.err
    assert {path.name for path in (tmp_path / "out").iterdir() if path.is_dir()} == {"reference", "initial"}
    stored = json.loads((tmp_path / "out" / "result.json").read_text(encoding="utf-8"))
    assert stored == ended.document


def test_the_same_candidate_twice_gets_two_folders(command, engine, tmp_path):
    assert command("check", "reference", "reference", "--output", "out").code == 0
    assert {path.name for path in (tmp_path / "out").iterdir() if path.is_dir()} == {
        "reference",
        "reference-2",
    }


@pytest.mark.parametrize(
    ("error", "code"), [(InputError("no step"), 2), (HarnessFault("broke"), 3), (KeyError("x"), 3)]
)
def test_a_check_that_ends_without_a_result_writes_nothing(command, engine, tmp_path, error, code):
    engine.error = error
    ended = command("check", "reference", "--json")
    assert ended.code == ended.document["error"]["exit_code"] == code
    assert list(tmp_path.iterdir()) == []


def test_a_report_that_cannot_be_written_is_a_fault_of_drivegate_beside_the_verdict(
    command, engine, monkeypatch, tmp_path
):
    class Broken:
        name = "broken"

        def load(self):
            raise ImportError("no such module")

    monkeypatch.setattr("drivegate.output.report_writers.entry_points", lambda group: [Broken()])
    ended = command("check", "reference")
    assert ended.code == 3
    assert "reference: pass" in ended.out
    assert "the report 'broken' could not be written" in ended.err
    data = command("check", "reference", "--json")
    assert data.document["verdict"] == "pass"
    assert data.document["error"]["exit_code"] == 3
    assert (tmp_path / "drivegate-report" / "result.json").exists()


def test_the_verdict_is_printed_and_stored_before_pages_are_written(
    command, failing, monkeypatch, tmp_path, capsys
):
    before = []

    class Page(OnePage):
        def load(self):
            write = super().load()

            def noted(document, folder):
                before.append((capsys.readouterr().out, names(tmp_path / "drivegate-report")))
                return write(document, folder)

            return noted

    monkeypatch.setattr("drivegate.output.report_writers.entry_points", lambda group: [Page()])
    assert command("check", "reference").code == 1
    ((printed, stored),) = before
    assert "CNV-1 fails (required)" in printed
    assert printed.splitlines()[-1].startswith("reference: exception, 2 runs")
    assert {"result.json", "counterexamples/CNV-1.json"} <= set(stored)
    assert "report.html" not in stored
    after = names(tmp_path / "drivegate-report")
    assert set(after) == {*stored, "report.html"}, "a page joins what is stored"
    mark = json.loads((tmp_path / "drivegate-report" / ".drivegate-report.json").read_text(encoding="utf-8"))
    assert sorted([*mark["files"], ".drivegate-report.json"]) == after


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        ([], "a candidate is missing"),
        (["nobody"], "'nobody' is unknown"),
        (["missing.py:Mine"], "does not exist"),
        (["reference", "--effort", "huge"], "--effort"),
        (["reference", "--seed", "-1"], "--seed"),
        (["reference", "--workers", "0"], "--workers"),
        (["reference", "--max-time", "0"], "above 0"),
        (["reference", "--max-time", "nan"], "above 0"),
        (["reference", "--output", "."], "working folder"),
        (["reference", "--output", "/proc/nowhere"], "cannot be written"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(refused, engine, words, reason):
    assert reason in refused("check", *words)


def test_a_class_without_step_is_refused_and_leaves_nothing(refused, controllers):
    assert "no method 'step'" in refused("check", f"{controllers}:WithoutStep", "--quiet")


def test_a_folder_of_somebody_else_is_refused(refused, engine, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("years of work", encoding="utf-8")
    assert "no report of drivegate" in refused("check", "reference", "--output", "mine")


def test_a_candidate_that_raises_is_checked_for_real(command, controllers, one_page, tmp_path):
    ended = command("check", f"{controllers}:Raising", "--effort", "quick", "--workers", "2", "--json")
    assert ended.document["verdict"] == FaultKind.EXCEPTION
    assert ended.document["exit_code"] == 1
    assert set(ended.document["faults"][0]) >= set(Fault.__dataclass_fields__) - {"time"}
    assert (tmp_path / "drivegate-report" / "summary.md").exists()


def test_a_contested_failure_is_listed_first_and_passes(command, engine, tmp_path):
    engine.outcomes = (
        outcome("CNV-1", "pass"),
        outcome("CNV-2", "contested", message="contested: none meets it"),
    )
    engine.verdict = "contested"
    ended = command("check", "reference")
    assert ended.code == 0
    rows = [line for line in ended.out.splitlines() if line.startswith((" CNV-1", " CNV-2"))]
    assert [row.split()[0] for row in rows] == ["CNV-2", "CNV-1"], "what is contested is listed first"
    assert (
        "contested: CNV-2: no known good controller meets it in the same scenario either, so it does"
        in ended.out
    )
    summary = (tmp_path / "drivegate-report" / "summary.md").read_text(encoding="utf-8")
    assert summary.index("## Contested") < summary.index("**CNV-2** contested") < summary.index("| check |")
    cases = ElementTree.parse(tmp_path / "drivegate-report" / "junit.xml").iter("testcase")
    case = next(case for case in cases if case.get("name") == "CNV-2")
    assert case.find("failure") is None
    assert "none meets it" in case.find("skipped").get("message")


def test_a_failure_that_is_not_witnessed_yet_is_a_state_of_its_own_everywhere(command, engine, tmp_path):
    engine.outcomes = (outcome("CNV-1", "inconclusive"), outcome("CNV-2", "not yet witnessed"))
    engine.verdict, engine.exit_code = "not yet witnessed", 1
    ended = command("check", "reference")
    assert ended.code == 1
    assert (
        "not yet witnessed: CNV-2: the check ended before known good controllers were run there" in ended.out
    )
    assert "CNV-2 fails, not yet witnessed" in ended.out
    assert "next: drivegate check reference --last-failed" in ended.out
    folder = tmp_path / "drivegate-report"
    summary = (folder / "summary.md").read_text(encoding="utf-8")
    assert summary.index("## Not yet witnessed") < summary.index("**CNV-2** not yet witnessed")
    assert "## What failed" not in summary
    cases = ElementTree.parse(folder / "junit.xml").iter("testcase")
    case = next(case for case in cases if case.get("name") == "CNV-2")
    assert case.find("failure") is None
    assert case.find("error").get("type") == "not yet witnessed"
    annotations = (folder / "annotations.txt").read_text(encoding="utf-8")
    assert "::warning title=reference CNV-2 not yet witnessed::" in annotations
    assert json.loads((folder / "result.json").read_text(encoding="utf-8"))["verdict"] == "not yet witnessed"


def test_a_witness_is_named_with_its_margin(command, engine):
    witness = WitnessedSection(
        name="predictive-flux", margin=0.62, measured="as good as it gets", knows_plant=False
    )
    engine.outcomes = (outcome("CNV-1", "fail").model_copy(update={"witness": witness}),)
    engine.verdict, engine.exit_code = "fail", 1
    assert "  predictive-flux meets it there with margin +0.62\n" in command("check", "reference").out


@pytest.mark.parametrize("counts", ["pass", "fail"])
def test_what_is_contested_counts_only_where_the_user_says_so(command, engine, counts):
    command("check", "reference", "--contested", counts)
    assert engine.options.contested == counts


def test_after_a_quick_pass_the_next_step_is_more_scenarios(command, engine):
    assert (
        "next: open the report; --effort default draws nine times as many"
        in command("check", "reference", "--effort", "quick").out
    )
    assert "nine times" not in command("check", "reference").out
