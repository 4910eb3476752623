"""`drivegate replay`: a counterexample is run again, by whom the user says, and judged."""

import json
import sys
from pathlib import Path

import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.output.console import console_for
from drivegate.results.provenance import provenance
from drivegate.studies.replay.display import next_step_of_all, show_all_replays
from drivegate.studies.replay.folder import document_of_all
from drivegate_cases.scenario.scenario import load_scenario

SCENARIO = load_scenario("lock-up").replaced(duration_s=12.0)


def counterexample(**changes):
    table = {
        "schema": 2,
        "kind": "counterexample",
        "check": "CNV-1",
        "margin": -2.5,
        "measured": "speed error 17.5 rpm",
        "candidate": {"name": "published", "hash": "00ff"},
        "scenario": SCENARIO.to_mapping(),
    }
    return table | changes


@pytest.fixture
def file(tmp_path):
    """Write a counterexample with some of its keys changed."""

    def write(**changes):
        path = tmp_path / "found" / "CNV-1.json"
        path.parent.mkdir(exist_ok=True)
        path.write_text(json.dumps(counterexample(**changes)), encoding="utf-8")
        return path

    return write


def test_the_published_search_still_fails_and_its_signals_are_drawn(command, file, tmp_path):
    ended = command("replay", file())
    assert ended.code == 1
    assert "CNV-1 STILL FAILS" in ended.out
    assert "then margin -2.5 (speed error 17.5 rpm), by published" in ended.out
    assert f"next: look at the signals: drivegate replay {file()} --plot CNV-1.svg" in ended.out
    assert "the angle passed 51.9°, the smallest at which the motor can give" in ended.out
    drawn = command("replay", file(), "--plot", "run.svg", "--json")
    document = drawn.document
    assert (drawn.code, document["exit_code"], document["verdict"]) == (1, 1, "still fails")
    assert document["now"]["margin"] < 0.0
    assert document["account"][0] == "Run: 1500 rpm; constant torque of 9.8 N·m; 12 s."
    assert document["then"] == {"margin": -2.5, "measured": "speed error 17.5 rpm"}
    assert document["window_s"][1] == SCENARIO.duration_s, "the stretch that was judged ends with the run"
    assert document["window_s"][0] > 6.0, "what comes before the stretch is not judged"
    assert document["files"] == ["run.svg"]
    drawing = (tmp_path / "run.svg").read_text(encoding="utf-8")
    for words in ("judged here", "speed", "advance angle", "current reference", "load", "feasible edge"):
        assert words in drawing


def test_the_reference_is_reported_to_be_right(command, file):
    ended = command("replay", file(), "--candidate", "reference")
    assert ended.code == 0
    assert "CNV-1 FIXED" in ended.out
    assert f"cp {file()} corpus/ && drivegate check reference --corpus corpus" in ended.out


def test_of_a_check_of_the_whole_run_the_moment_that_decides_is_stated(command, file, controllers):
    scenario = SCENARIO.replaced(duration_s=1.0).to_mapping()
    words = (
        "replay",
        file(check="CUR-1", scenario=scenario),
        "--candidate",
        f"{controllers}:Steady",
        "--json",
    )
    start, end = command(*words).document["window_s"]
    assert end - start < 0.2, "what is shown is the greatest current of the whole run"


def test_a_repetition_is_repeated(command, file):
    words = ("replay", file(check="DET-1", scenario=SCENARIO.replaced(duration_s=1.0).to_mapping()), "--json")
    ended = command(*words)
    assert (ended.code, ended.document["verdict"], ended.document["now"]["margin"]) == (0, "fixed", 1.0)


def test_a_check_that_does_not_apply_says_why(command, file, controllers):
    scenario = SCENARIO.replaced(duration_s=1.0).to_mapping()
    words = ("replay", file(check="PWR-2", scenario=scenario), "--candidate", f"{controllers}:Steady")
    text, data = command(*words), command(*words, "--json")
    assert text.code == data.code == 0
    assert "PWR-2 NOT APPLICABLE" in text.out
    assert data.document["reason"]
    assert data.document["now"] is None


def test_a_candidate_that_raises_still_fails(command, file, controllers):
    words = ("replay", file(), "--candidate", f"{controllers}:Raising", "--plot", "run.svg")
    text, data = command(*words), command(*words, "--json")
    assert text.code == data.code == 1
    assert "\x1b" not in text.out
    assert "exception: ValueError" in text.out
    assert (data.document["verdict"], data.document["fault"]["kind"]) == ("still fails", "exception")
    assert data.document["files"] == []


@pytest.mark.parametrize(
    "name",
    ["mine.py:Mine", "os:system", "exec:touch owned", "./drive.so", "\x1b[31m<script>", "faulty:../x", "a b"],
)
def test_a_file_does_not_say_what_is_executed(refused, file, name):
    sentence = refused("replay", file(candidate={"name": name}))
    assert "does not come with drivegate; say which one to run with --candidate" in sentence
    assert "\x1b" not in sentence


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["missing.json"], "missing.json does not exist"),
        (["controllers.txt"], "neither a TOML nor a JSON file"),
        ([], "FILE|FOLDER"),
        (
            ["."],
            ". holds no counterexample; name the report of a check that failed, such as drivegate-report",
        ),
        ([".", "--plot", "run.svg"], "--plot draws one counterexample, but a folder is named"),
        (["FOUND", "--candidate", "nobody"], "'nobody' is unknown"),
        (["FOUND", "--plot", "run.pdf"], ".png or .svg"),
        (["FOUND", "--plot", "no/where.svg"], "folder does not exist"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(refused, file, words, reason):
    found = str(file())
    assert reason in refused("replay", *(found if word == "FOUND" else word for word in words))


@pytest.mark.parametrize(
    ("changes", "reason"),
    [({"schema": 9}, "schema 9 is newer"), ({"check": "XYZ-1"}, "'XYZ-1'"), ({"kind": "result"}, "kind")],
)
def test_a_bad_file_is_refused_in_one_sentence(refused, file, changes, reason):
    assert reason.strip("'") in refused("replay", file(**changes))


BY_CHANCE = """
import random

from drivegate import Command


class Mine:
    def reset(self, nameplate):
        self.draw = random.Random(0) if SEEDED else random.SystemRandom()

    def step(self, sense):
        return Command(current_reference=CURRENT + self.draw.random(), advance_angle=0.9)
"""


@pytest.fixture
def by_chance(tmp_path, file):
    """Write a controller that draws random numbers, and a counterexample that it left a moment ago."""

    def written(*, seeded, margin=-2.5, current=20.0, **changes):
        path = tmp_path / "chance.py"
        path.write_text(
            BY_CHANCE.replace("SEEDED", str(seeded)).replace("CURRENT", str(current)), encoding="utf-8"
        )
        candidate = resolve_candidate(f"{path}:Mine")
        left = {
            "candidate": {"name": candidate.name, "hash": candidate.content_hash},
            "versions": provenance(),
            "margin": margin,
            "scenario": SCENARIO.replaced(duration_s=1.0).to_mapping(),
        }
        return file(**(left | changes)), candidate.specification

    return written


def test_what_does_not_show_again_with_nothing_changed_is_not_called_fixed(command, by_chance):
    path, candidate = by_chance(seeded=False, check="CMD-1")
    ended = command("replay", path, "--candidate", candidate)
    assert "CMD-1 NOT REPRODUCED" in ended.out
    assert "two runs of the same scenario differ" in ended.out
    assert "if the controller draws random numbers, seed them in reset" in ended.out
    assert ended.out.splitlines()[-1] == f"next: what differs: drivegate check {candidate} --only DET-1"
    assert ended.code == 1, "nothing was mended"


def test_a_folder_reports_it_too(command, by_chance):
    path, candidate = by_chance(seeded=False, check="CMD-1")
    ended = command("replay", path.parent, "--candidate", candidate)
    assert "1 counterexample: 1 not reproduced" in ended.out
    assert ended.out.splitlines()[-1].endswith("--only DET-1")
    assert ended.code == 1, "nothing was mended"


def test_another_margin_of_the_same_failure_is_reported(command, by_chance):
    path, candidate = by_chance(seeded=False, check="CMD-1", current=80.0)
    ended = command("replay", path, "--candidate", candidate, "--json").document
    assert ended["verdict"] == "still fails"
    assert ended["remark"].startswith("two runs of the same scenario differ")


@pytest.mark.parametrize("change", ["nothing", "versions", "candidate"])
def test_what_was_changed_or_repeats_itself_has_no_such_remark(command, by_chance, change):
    path, candidate = by_chance(seeded=True, check="CUR-1")
    now = command("replay", path, "--candidate", candidate, "--json").document["now"]["margin"]
    other = {
        "nothing": {"margin": now},
        "versions": {"versions": {}},
        "candidate": {"candidate": {"name": "mine"}},
    }
    path, candidate = by_chance(seeded=True, check="CUR-1", **other[change])
    again = command("replay", path, "--candidate", candidate, "--json").document
    assert (again["remark"], again["verdict"]) == ("", "fixed" if now >= 0.0 else "still fails")


SHORT = SCENARIO.replaced(duration_s=1.0).to_mapping()


@pytest.fixture
def report(tmp_path):
    """Write a report's folder with counterexamples by check, each of another candidate."""

    def write(folder="drivegate-report", **names):
        place = tmp_path / folder / "counterexamples"
        place.mkdir(parents=True)
        (tmp_path / folder / "result.json").write_text("{}", encoding="utf-8")
        for check, name in names.items():
            table = counterexample(check=check.replace("_", "-"), scenario=SHORT, candidate={"name": name})
            (place / f"{table['check']}.json").write_text(json.dumps(table), encoding="utf-8")
        return tmp_path / folder

    return write


def test_every_counterexample_of_a_report_is_reported_on_one_line(command, report, controllers):
    folder = report(CMD_1="published", PWR_2="published", DET_1="published")
    ended = command("replay", folder, "--candidate", f"{controllers}:Steady")
    assert ended.code == 0, ended.err
    *lines, total, following = ended.out.splitlines()
    assert [line.split()[:2] for line in lines] == [
        ["FIXED", "CMD-1"],
        ["FIXED", "DET-1"],
        ["NOT", "APPLICABLE"],
    ]
    for line, check in zip(lines, ("CMD-1", "DET-1", "PWR-2"), strict=True):
        assert line.endswith(f"{folder}/counterexamples/{check}.json")
    assert "was -2.5, by controllers.py:Steady" in lines[0]
    assert total == "3 counterexamples: 2 fixed, 1 not applicable"
    assert f"cp {folder}/counterexamples/*.json corpus/ && drivegate check" in following
    assert "replay: " not in ended.out, "progress belongs on standard error"


def test_one_that_still_fails_decides_and_the_folder_inside_will_do(command, report, controllers):
    folder = report(CMD_1="published", DET_1="published") / "counterexamples"
    words = ("replay", folder, "--candidate", f"{controllers}:Raising")
    text, data = command(*words), command(*words, "--json")
    assert text.code == data.code == data.document["exit_code"] == 1
    assert "2 counterexamples: 2 still fail\n" in text.out
    assert (
        f"next: drivegate replay {folder}/CMD-1.json --candidate {controllers}:Raising --plot CMD-1.svg"
        in text.out
    )
    assert data.document["counts"] == {
        "still fails": 2,
        "not reproduced": 0,
        "fixed": 0,
        "not applicable": 0,
    }
    assert [replay["check"] for replay in data.document["replays"]] == ["CMD-1", "DET-1"]
    single = command("replay", folder / "CMD-1.json", *words[2:], "--json").document
    assert data.document["replays"][0] == {"file": str(folder / "CMD-1.json")} | single


def test_each_file_of_a_folder_runs_its_own_candidate(command, report, tmp_path):
    report("both/initial", CMD_1="initial")
    report("both/reference", CMD_1="reference")
    documents = command("replay", tmp_path / "both", "--json").document["replays"]
    assert [document["candidate"]["name"] for document in documents] == ["initial", "reference"]


def test_a_corpus_is_replayed_and_a_broken_file_in_it_refused(command, refused, file):
    corpus = file(check="CMD-1", scenario=SHORT, candidate={"name": "reference"}).parent
    ended = command("replay", corpus)
    assert (ended.code, ended.out.count("FIXED")) == (0, 1)
    assert f"next: drivegate check reference --corpus {corpus}" in ended.out
    (corpus / "broken.json").write_text("{", encoding="utf-8")
    assert "broken.json" in refused("replay", corpus)


def test_a_report_without_counterexamples_names_what_would_be_right(refused, report):
    assert "holds no counterexample; name the report of a check that failed" in refused("replay", report())


def test_a_folder_does_not_say_what_is_executed(refused, report):
    folder = report(CMD_1="reference", DET_1="mine.py:Mine")
    assert "say which one to run with --candidate" in refused("replay", folder)


def _ended(check, level, verdict):
    return {
        "check": check,
        "level": level,
        "verdict": verdict,
        "file": f"{check}.json",
        "fault": None,
        "exit_code": int(verdict == "still fails"),
        "candidate": {"name": "mine"},
        "reason": "",
        "now": {"margin": -0.5, "measured": "x"},
        "then": {"margin": -1.0},
    }


def test_of_a_folder_required_failures_come_first_and_alone_count(capsys):
    advised = [_ended("EFF-1", "advisory", "still fails"), _ended("ACC-1", "required", "fixed")]
    assert document_of_all(Path("report"), advised)["exit_code"] == 0
    document = document_of_all(Path("report"), [*advised, _ended("STP-1", "required", "still fails")])
    assert document["exit_code"] == 1
    show_all_replays(console_for(sys.stdout), document, "mend it")
    *lines, total, _ = capsys.readouterr().out.splitlines()
    assert [line.split()[2] for line in lines[:2]] == ["STP-1", "EFF-1"]
    assert total == "3 counterexamples: 2 still fail (1 of them advisory, which do not count), 1 fixed"
    assert "STP-1.json" in next_step_of_all(document, None)
