"""`drivegate simulate`: one run, its summary and its files."""

import json
import re

import pandas
import pytest

from drivegate.contracts.current.columns import EXTREMES
from drivegate.output.result_file import counterexamples
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import load_scenario
from drivegate_models.loop.observation import TRACE_COLUMNS


@pytest.fixture
def short(tmp_path):
    """A scenario of 10 s, so long that there is a steady stretch to judge."""
    file = tmp_path / "short.json"
    file.write_text(load_scenario("lock-up").replaced(duration_s=10.0).to_json(), encoding="utf-8")
    return file


@pytest.mark.nightly
def test_a_run_is_summarised_and_its_trace_written(command, short, tmp_path):
    files = ("--csv", "run.csv", "--plot", "run.svg")
    document = command("simulate", "reference", "--case", short, *files, "--json").document
    summary = document["summary"]
    trace = pandas.read_csv(tmp_path / "run.csv")
    own = [name for name in TRACE_COLUMNS if name not in EXTREMES]
    sensed = [f"sensed_phase_{phase}_a" for phase in range(1, 6)]
    assert list(trace.columns) == [*own, *sensed, "sensed_current_sum_a"]
    assert len(trace) == summary["steps"] == 20_000
    assert trace["speed_rpm"].iloc[-1] == pytest.approx(summary["speed_final_rpm"], abs=1.0)
    assert abs(trace["speed_rpm"] - trace["speed_reference_rpm"]).max() == summary["speed_error_worst_rpm"]
    assert summary["energy_residual"] < 1e-9
    assert [window["end_s"] for window in document["windows"]] == [10.0]
    assert document["windows"][0]["torque_mean_nm"] == pytest.approx(9.8, rel=0.01)
    assert document["files"] == ["run.csv", "run.svg"]
    assert "<svg" in (tmp_path / "run.svg").read_text(encoding="utf-8")


def test_people_get_tables_and_the_way_to_a_plot(command, short):
    ended = command("simulate", "initial", "--case", short)
    assert ended.code == 0
    assert "steady from" in ended.out
    assert "--plot" in ended.out


def test_commands_out_of_range_and_a_wrong_unit_are_reported(command, short, tmp_path):
    (tmp_path / "mine.py").write_text(
        "from drivegate import Command\n"
        "class Degrees:\n def reset(self, nameplate): pass\n def step(self, sense): return Command(5000.0, 57.0)\n"
        "class Less:\n def reset(self, nameplate): pass\n def step(self, sense): return Command(-1.0, -0.02)\n",
        encoding="utf-8",
    )
    short.write_text(load_scenario("lock-up").replaced(duration_s=0.5).to_json(), encoding="utf-8")
    more = command("simulate", f"{tmp_path / 'mine.py'}:Degrees", "--case", short).out
    assert "advance angle clamped to 90°: up to 57 rad: degrees?" in more, more
    assert "current reference clamped to its limit of 26 A: up to 5000 A: milliamperes?" in more, more
    less = command("simulate", f"{tmp_path / 'mine.py'}:Less", "--case", short, "--json").document
    assert less["clamped"] == [
        "advance angle clamped to 0: down to -0.02 rad (-1.146°)",
        "current reference clamped to 0: down to -1 A",
    ]
    assert command("simulate", "reference", "--case", short, "--json").document["clamped"] == []


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("mine.yaml", "is no manifest that drivegate reads; write it as TOML, such as mine.toml"),
        ("empty", "is a folder, but must be a file in it or a name; write empty/candidate.toml"),
        ("full", "is a folder, but must be a file in it or a name; write full/controller.py:Class"),
    ],
)
def test_a_folder_or_another_manifest_names_what_to_write(command, tmp_path, name, expected):
    (tmp_path / "empty").mkdir()
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "controller.py").touch()
    ended = command("simulate", name, "--case", "lock-up")
    assert ended.code == 2
    assert expected in ended.err, ended.err


def test_a_python_candidate_runs_and_a_drive_can_be_altered(command, short, controllers, tmp_path):
    words = ("simulate", f"{controllers}:Steady", "--case", short, "--json")
    nominal = command(*words).document
    altered = command(
        *words, "--set", "friction_n_m=5", "--drive", "paper-5-phase", "--plot", "x.png"
    ).document
    assert altered["summary"]["speed_final_rpm"] <= nominal["summary"]["speed_final_rpm"]
    assert altered["summary"]["shaft_power_mean_w"] != nominal["summary"]["shaft_power_mean_w"]
    assert (tmp_path / "x.png").read_bytes().startswith(b"\x89PNG")


def test_a_candidate_that_raises_ends_with_1_and_cannot_write_to_the_terminal(command, short, controllers):
    words = ("simulate", f"{controllers}:Raising", "--case", short, "--csv", "run.csv")
    text, data = command(*words), command(*words, "--json")
    assert (text.code, data.code) == (1, 1)
    assert "\x1b" not in text.out
    assert "[bold]x[/bold]" in text.out
    assert "  in step " in text.out, text.out
    assert data.document["fault"]["kind"] == "exception"
    assert data.document["fault"]["step"] == 0


def test_a_counterexample_is_a_case_too(command, failing, tmp_path):
    command("check", "reference")
    result = json.loads((tmp_path / "drivegate-report" / "result.json").read_text(encoding="utf-8"))
    file = tmp_path / "drivegate-report" / "counterexamples" / "CNV-1.json"
    stored = json.loads(file.read_text(encoding="utf-8"))
    assert stored == counterexamples(result)[0]
    short = json.dumps({**stored, "scenario": {**stored["scenario"], "duration_s": 0.5}})
    file.write_text(short, encoding="utf-8")
    document = command("simulate", "initial", "--case", file, "--json").document
    assert (document["scenario"], document["duration_s"]) == ("lock-up", 0.5)


def test_a_script_is_to_be_replayed(refused, tmp_path):
    file = tmp_path / "FLO-1.json"
    file.write_text(json.dumps({"kind": "counterexample", "scenario": {"kind": "script"}}), encoding="utf-8")
    assert f"drivegate replay {file}" in refused("simulate", "published", "--case", file)


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["nobody", "--case", "lock-up"], "'nobody' is unknown"),
        (["missing.py:Mine", "--case", "lock-up"], "missing.py does not exist"),
        (["missing_module:Mine", "--case", "lock-up"], "missing_module"),
        (["reference", "--case", "lock-upp"], "'lock-up'"),
        (["reference", "--case", "missing.toml"], "missing.toml does not exist"),
        (["reference"], "--case"),
        (["reference", "--case", "lock-up", "--csv", "no/where.csv"], "folder does not exist"),
        (["reference", "--case", "lock-up", "--csv", "."], "is a folder"),
        (["reference", "--case", "lock-up", "--plot", "run.pdf"], ".png or .svg"),
        (["reference", "--case", "lock-up", "--csv", "run.png", "--plot", "run.png"], "the same file"),
        (["reference", "--case", "lock-up", "--set", "inductence_h=1"], "'inductance_h'"),
        (["reference", "--case", "lock-up", "--set", "emf_flat_deg=190"], "emf_flat_deg"),
        (["drive.c", "--case", "lock-up"], "drive.c does not exist"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(refused, words, reason):
    assert reason in refused("simulate", *words)


def test_a_class_without_step_is_refused(refused, controllers):
    assert "no method 'step'" in refused("simulate", f"{controllers}:WithoutStep", "--case", "lock-up")


def test_a_class_that_is_not_there_is_refused(refused, controllers):
    assert "Stedy" in refused("simulate", f"{controllers}:Stedy", "--case", "lock-up")


def test_a_syntax_error_is_refused_with_its_line(refused, tmp_path):
    (tmp_path / "wrong.py").write_text("class Mine:\n    def step(self, sense)\n", encoding="utf-8")
    assert "line 2" in refused("simulate", "wrong.py:Mine", "--case", "lock-up")


def test_a_binary_file_is_no_scenario(refused, tmp_path):
    (tmp_path / "case.toml").write_bytes(b"\x7fELF\xff\xfe\x00")
    assert "UTF-8" in refused("simulate", "reference", "--case", "case.toml")


def test_parquet_without_its_library_is_refused(refused, monkeypatch):
    monkeypatch.setattr("drivegate.output.trace_files.find_spec", lambda name: None)
    assert "pyarrow" in refused("simulate", "reference", "--case", "lock-up", "--parquet", "run.parquet")


@pytest.mark.parametrize("name", ["CNV-1", "lock-up"])
def test_a_run_of_a_report_is_run_by_its_name_or_its_check_also_when_it_passed(
    command, engine, tmp_path, name
):
    command("check", "reference")
    result = tmp_path / "drivegate-report" / "result.json"
    document = json.loads(result.read_text(encoding="utf-8"))
    document["checks"][0]["scenario"]["duration_s"] = 0.5
    result.write_text(json.dumps(document), encoding="utf-8")
    ended = command("simulate", "reference", "--from", "drivegate-report", "--run", name)
    assert "lock-up, 0.5 s" in ended.out, "the scenario is the report's, not the one that comes along"
    assert (
        f"next: drivegate simulate reference --from drivegate-report --run {name} --plot run.png" in ended.out
    )


def test_a_run_that_a_report_does_not_keep_is_refused(command, refused, engine):
    command("check", "reference")
    words = ("simulate", "reference", "--from", "drivegate-report")
    assert "keeps no run 'lock-upp', the nearest is 'lock-up'" in refused(*words, "--run", "lock-upp")
    assert "--from FOLDER --run NAME" in refused(*words)
    assert "--from FOLDER --run NAME" in refused(*words, "--run", "CNV-1", "--case", "lock-up")


SLOW = """
import time
from drivegate import Command

class Slow:
    def reset(self, nameplate): pass
    def step(self, sense):
        time.sleep(0.005)
        return Command(current_reference=5.0, advance_angle=0.5)
"""


def test_a_run_that_will_take_long_is_reported_while_it_runs(command, tmp_path, monkeypatch):
    monkeypatch.setattr("drivegate.containment.watches.KNOWN_AFTER", 0.3)
    monkeypatch.setattr("drivegate.containment.watches.LONG", 1.0)
    case = tmp_path / "half.json"
    case.write_text(load_scenario("lock-up").replaced(duration_s=0.25).to_json(), encoding="utf-8")
    (tmp_path / "slow.py").write_text(SLOW, encoding="utf-8")
    ended = command("simulate", "slow.py:Slow", "--case", case, "--json")
    assert ended.code == 0
    assert ended.document["summary"]["steps"] == 500, "what is reported changes nothing"
    (line,) = [line for line in ended.err.splitlines() if "at this pace" in line]
    assert line.startswith("at this pace this run takes about "), line
    stated = re.search(r": 500 steps of ([0-9.]+) s each", line)
    assert stated, line
    # Steps are counted in whole ones, and a busy machine adds to the 5 ms of each.
    assert float(stated[1]) > 0.004, line
    fast = command("simulate", "initial", "--case", case)
    assert "at this pace" not in fast.err


def test_a_drive_a_thousand_times_off_its_kind_warns_and_runs_all_the_same(command, tmp_path):
    case = tmp_path / "brief.json"
    brief = load_scenario("lock-up").replaced(duration_s=0.25)
    case.write_text(brief.to_json(), encoding="utf-8")
    ended = command("simulate", "initial", "--case", case, "--set", "inductance_h=2.88", "--json")
    assert (ended.code, ended.document["fault"]) == (0, None)
    (warning,) = [line for line in ended.err.splitlines() if line.startswith("warning: ")]
    assert warning.startswith(
        "warning: the drive's inductance_h is 2.88, but usual for 48 V and 26 A at 500 rpm"
    )
    assert warning.endswith("it is expected in henry: is it in millihenry?")
    case.write_text(
        brief.replaced(drive=brief.drive.with_overrides(["resistance_ohm=300"])).to_json(), "utf-8"
    )
    assert "warning: the drive's resistance_ohm is 300" in command("simulate", "initial", "--case", case).err


def test_a_star_is_run_through_hall_switches(command, tmp_path):
    file = tmp_path / "hall.json"
    star = load_scenario("lock-up").replaced(
        duration_s=10.0, drive=load_drive("star-3-phase"), sensors="hall", seed=5
    )
    file.write_text(star.to_json(), encoding="utf-8")
    run = ("simulate", "reference", "--case", file, "--drive", "star-3-phase")
    summary = command(*run, "--json").document["summary"]
    assert summary["energy_residual"] < 1e-9
    assert summary["speed_final_rpm"] == pytest.approx(1500.0, abs=5.0)


@pytest.mark.parametrize("run", [("simulate", "reference"), ("diff", "reference", "published")])
def test_the_next_command_is_of_the_same_drive(command, tmp_path, run):
    brief = load_scenario("lock-up").replaced(duration_s=2.0)
    file = tmp_path / "brief.json"
    file.write_text(brief.to_json(), encoding="utf-8")
    chosen = ("--case", file, "--drive", "star-3-phase", "--set", "window_deg=150")
    stated = " ".join(command(*run, *chosen).out.split())
    assert f"next: drivegate {' '.join(run)} {' '.join(map(str, chosen))} --plot" in stated


def test_hall_switches_are_refused_in_a_sentence_on_another_drive(command, tmp_path):
    file = tmp_path / "hall.toml"
    file.write_text(
        'schema = 2\nname = "mine"\ndrive = "star-3-phase"\nduration_s = 1.0\nspeed_rpm = [[0.0, 1000.0]]\n'
        'sensors = "hall"\n[load]\nkind = "locked"\n',
        encoding="utf-8",
    )
    ended = command("simulate", "reference", "--case", file, "--drive", "paper-5-phase")
    assert ended.code == 2
    assert "the sensors 'hall' are three switches for a drive with 3 phases, but this one has 5" in ended.err
    assert "Traceback" not in ended.err
