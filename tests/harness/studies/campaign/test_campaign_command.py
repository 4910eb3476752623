"""`drivegate campaign` from end to end: bytes, faults, refusals, and a folder that cannot be written."""

import errno
import html
import json
import os
import re
import resource
import shlex
from pathlib import Path

import pandas
import pytest

from drivegate.commands.command_line import main
from drivegate.studies.campaign.folder import LOCK, MANIFEST
from drivegate_cases.drive.drive_document import load_drive
from drivegate_reports.campaign.report import REPORT_FILE


@pytest.mark.nightly
def test_the_bytes_do_not_depend_on_the_number_of_workers(write, finish, finish_alone, folder, bytes_of):
    file = write(candidates=["reference", "controllers.py:Counting"], draws=4)
    finish(file, "one")
    summary = finish_alone(file, "two", 2)
    one, two = bytes_of(folder / "one"), bytes_of(folder / "two")
    assert one == two, f"these differ: {[name for name in one | two if one.get(name) != two.get(name)]}"
    assert LOCK not in one
    assert summary["timing"]["runs_made"] == 8
    frame = pandas.read_parquet(folder / "two" / "runs")
    assert sorted(frame["run"]) == list(range(8))
    assert set(frame["candidate"]) == {"reference", "controllers.py:Counting"}
    counting = frame[frame["candidate"] == "controllers.py:Counting"].sort_values("run")
    # A class that counts its resets shows which runs have shared a process: those of one file.
    assert (counting["current_peak_a"].diff().iloc[1::2] > 0.5).all()


def test_a_fault_is_a_row_and_the_worst_cases_can_be_run_again(write, finish, run, folder):
    file = write(
        candidates=["controllers.py:Dying", "controllers.py:Raising", "published"],
        cases=["short.json", "lock-up"],
        grid={"inertia_kg_m2": [0.05, 0.06]},
        draws=1,
        runs_per_file=4,
        checks=["ADV-2", "CMD-1", "ROB-1"],
    )
    document = finish(file, "out")
    frame = pandas.read_parquet(folder / "out" / "runs").sort_values("run")
    by_name = {name: rows["verdict"].tolist() for name, rows in frame.groupby("candidate", observed=True)}
    assert by_name["controllers.py:Dying"][:2] == ["pass", "crash"]
    assert by_name["controllers.py:Raising"][:2] == ["pass", "exception"]
    assert by_name["published"] == ["pass", "pass", "fail", "fail"]
    assert "SIGSEGV" in frame["message"].iloc[1]
    dying, raising, published = document["candidates"]
    assert dying["first_faults"][0]["run"] == 1
    assert raising["verdicts"]["exception"] == 2
    assert (folder / "out" / dying["first_faults"][0]["file"]).is_file()
    broken = next(check for check in published["checks"] if check["id"] == "ROB-1")
    assert (broken["violations"], broken["runs"], broken["interval"]) == (2, 2, None)
    at = [
        (point["case"], point["parameters"], point["violations"], point["runs"]) for point in broken["points"]
    ]
    short = json.loads((folder / "short.json").read_text(encoding="utf-8"))["name"]
    assert at == [
        (case, {"inertia_kg_m2": inertia}, int(case == "lock-up"), int(case == "lock-up"))
        for case in (short, "lock-up")
        for inertia in (0.05, 0.06)
    ], "each case with each point of the grid, none of which speaks for another"
    again = run("replay", Path("out") / broken["counterexample"], "--json")
    assert again.code == 1, again.err
    assert json.loads(again.out)["now"]["margin"] == pytest.approx(broken["worst_margin"])


def test_every_command_of_the_page_and_of_the_console_works_as_printed(write, run, folder, monkeypatch):
    file = write(
        candidates=["controllers.py:Dying", "published"],
        cases=["short.json", "lock-up"],
        grid={"inertia_kg_m2": [0.05, 0.06]},
        draws=1,
        runs_per_file=4,
        checks=["ADV-2", "ROB-1"],
    )
    ended = run("campaign", file, "--output", "my out", "--workers", 1)
    assert ended.code == 0, ended.err
    hints = [line.removeprefix("next: ") for line in ended.out.splitlines() if line.startswith("next: ")]
    assert hints[0].startswith(f"my out/{REPORT_FILE} ")
    assert run(*shlex.split(hints[1])[1:]).code == 1, "it still fails"
    page = folder / "my out" / REPORT_FILE
    text = page.read_text(encoding="utf-8")
    listed = [html.unescape(command) for command in re.findall("<code>drivegate (.*?)</code>", text)]
    assert len(listed) == len(set(listed)) == 5, "a crash, and two checks of each candidate"
    monkeypatch.chdir(page.parent)
    for command in listed:
        with pytest.raises(SystemExit) as again:
            main(shlex.split(command))
        assert again.value.code in (0, 1), f"{command}: it ends with {again.value.code}"


def test_people_get_a_table_a_hint_and_progress_in_lines(write, run):
    ended = run("campaign", write(draws=2), "--workers", 1)
    assert ended.code == 0
    assert "reference: 2 pass" in ended.out
    assert "95 % interval" in ended.out
    assert "results: drivegate-campaign" in ended.out
    assert ended.err.splitlines()[-1].startswith("small: 2 of 2 runs, ")


def test_a_drive_with_a_value_in_a_wrong_unit_is_warned_of_once(write, run, folder, short_case):
    case = json.loads(short_case)
    case["drive"]["machine"]["resistance_ohm"] = 80.0
    for name in ("short.json", "again.json"):
        (folder / name).write_text(json.dumps(case | {"name": name}), encoding="utf-8")
    ended = run("campaign", write(draws=1, cases=["short.json", "again.json"]), "--workers", 1)
    assert ended.code == 0, ended.err
    assert ended.err.count("warning: the drive's resistance_ohm is 80, but usual for 48 V and 26 A is ") == 1


def test_drives_that_no_controller_could_serve_are_set_aside(write, finish):
    document = finish(write(grid={"load_share": [1.0, 3.0]}, spread={}, draws=1), "out")
    (candidate,) = document["candidates"]
    assert candidate["verdicts"] == {"pass": 1, "set aside": 1}
    assert candidate["not_passed"]["runs"] == 1


def test_another_campaign_or_another_version_of_a_candidate_is_refused(
    write, finish, refused, folder, bytes_of
):
    controllers = folder / "controllers.py"
    finish(write(candidates=["controllers.py:Steady"], draws=2), "out")
    before = bytes_of(folder / "out")
    other = write("other.json", candidates=["controllers.py:Steady"], draws=3)
    sentence = refused(other, "--output", "out")
    assert "holds another campaign, 'small'" in sentence
    assert "the key 'draws' differs" in sentence
    original = controllers.read_text(encoding="utf-8")
    controllers.write_text(original + "# changed\n", encoding="utf-8")
    sentence = refused("campaign.json", "--output", "out")
    assert "another version of the candidate 'controllers.py:Steady'" in sentence
    controllers.write_text(original, encoding="utf-8")
    assert bytes_of(folder / "out") == before, "a refusal must not touch what is there"
    path = folder / "out" / MANIFEST
    manifest = json.loads(path.read_text(encoding="utf-8"))
    manifest["versions"]["drivegate"] = "0.0.1"
    path.write_text(json.dumps(manifest), encoding="utf-8")
    assert "other versions of drivegate" in refused("campaign.json", "--output", "out")


def test_a_folder_that_is_not_its_own_or_cannot_be_written_is_refused(write, refused, folder):
    file = write()
    foreign = folder / "foreign"
    foreign.mkdir()
    (foreign / "thesis.txt").write_text("mine", encoding="utf-8")
    assert "no campaign of drivegate" in refused(file, "--output", "foreign")
    assert [path.name for path in foreign.iterdir()] == ["thesis.txt"]
    assert "is a file" in refused(file, "--output", file)
    assert "Not a directory" in refused(file, "--output", f"{file}/below")
    assert "/proc" in refused(file, "--output", "/proc/campaign")


def test_a_candidate_that_is_refused_ends_the_campaign_before_any_run(write, refused, folder):
    (folder / "broken.py").write_text("class Mine: pass\n", encoding="utf-8")
    sentence = refused(write(candidates=["reference", "broken.py:Mine"]), "--output", "out")
    assert "Mine" in sentence
    assert list((folder / "out").rglob("*.parquet")) == []


@pytest.fixture
def small_files(monkeypatch):
    """Let no file grow beyond what a manifest needs, as on a disk that is full."""
    _, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    return lambda limit: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, hard))


@pytest.mark.nightly
def test_a_full_disk_is_one_sentence_and_the_campaign_goes_on_with_room(
    write, refused, finish, folder, bytes_of, small_files
):
    file = write(draws=4)
    finish(file, "whole")
    sizes = [path.stat().st_size for path in (folder / "whole" / "runs").rglob("*.parquet")]
    limit = (folder / "whole" / MANIFEST).stat().st_size + 1
    assert limit < max(sizes), "the limit must lie between the manifest and the results"
    before = resource.getrlimit(resource.RLIMIT_FSIZE)[0]
    small_files(limit)
    try:
        sentence = refused(file, "--output", "out", "--workers", 1)
    finally:
        small_files(before)
    assert os.strerror(errno.EFBIG) in sentence
    assert "goes on" in sentence
    assert list((folder / "out").rglob("*.partial")) == []
    assert list((folder / "out").rglob("*.parquet")) == []
    finish(file, "out")
    assert bytes_of(folder / "out") == bytes_of(folder / "whole")


def test_a_damaged_file_is_named(write, refused, finish, folder):
    file = write(draws=4)
    finish(file, "out")
    damaged = next((folder / "out" / "runs").rglob("*.parquet"))
    damaged.write_bytes(damaged.read_bytes()[:100])
    sentence = refused(file, "--output", "out")
    assert damaged.name in sentence
    assert "delete it" in sentence


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("--backend", "dask"), "needs --scheduler"),
        (("--scheduler", "tcp://127.0.0.1:1"), "goes with --backend dask only"),
        (("--backend", "dask", "--scheduler", "x", "--workers", "2"), "goes with --backend local only"),
        (("--confidence", "1"), "from 0.5 to 0.999999"),
        (("--backend", "dusk"), "dusk"),
    ],
)
def test_options_that_do_not_go_together_are_refused(write, refused, words, reason):
    assert reason in refused(write(), *words)


def test_a_drive_takes_the_place_of_every_case_s_and_is_not_mixed_with_another(write, run, folder):
    mine = load_drive("paper-5-phase").replaced(name="mine", resistance_ohm=0.1)
    (folder / "mine.json").write_text(mine.to_json(), encoding="utf-8")
    file = write(draws=1)
    ended = run("campaign", file, "--workers", 1, "--drive", folder / "mine.json", "--json")
    assert ended.code == 0, ended.err
    assert set(map(json.dumps, json.loads(ended.out)["drives"].values())) == {json.dumps(mine.identity())}
    again = run("campaign", file, "--workers", 1)
    assert again.code == 2
    assert "'cases' differs" in again.err
