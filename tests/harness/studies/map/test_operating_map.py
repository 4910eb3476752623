"""Operating maps against the single points that they are made of."""

import json
from math import isfinite, pi, radians

import numpy as np
import pandas
import psutil
import pytest
from tests.harness.ended import ended

from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.backend import Backend
from drivegate.studies.map.plan import MapAxes, MapPlan, axis_within, parameter_axis
from drivegate.studies.map.run import computed
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.errors import InputError
from drivegate_models.steady.oracle import feasible_edge, least_current_sum
from drivegate_models.steady.steady_state import steady_state


def silent(_done: int, _before: int) -> None:
    return


def frame_of(kind, axes, candidate=None, workers=1):
    drive = load_drive("paper-5-phase")
    plan = MapPlan(kind, drive, MapAxes.of(axes), candidate)
    return pandas.DataFrame(computed(plan, Backend(workers=workers), silent).table())


@pytest.fixture
def command(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)

    def run(*words: object) -> tuple[int, str, str]:
        of_map = ended(capsys, "map", *words)
        return of_map.code, of_map.out, of_map.err

    return run


def test_every_point_of_a_map_is_the_steady_state_there():
    axes = {"speed_rpm": (300.0, 1500.0), "advance_deg": (0.0, 52.5), "current_a": (5.0, 20.0)}
    frame = frame_of("points", axes)
    drive = load_drive("paper-5-phase").plant()
    assert len(frame) == 8
    for row in frame.itertuples():
        state = steady_state(drive, row.speed_rpm * pi / 30.0, row.current_a, radians(row.advance_deg))
        assert row.torque_mean_nm == state.torque
        assert row.current_sum_a == state.current_sum
        assert row.input_power_w == state.source_power + state.core_source_power + state.switching_loss
        assert row.certified == bool(state.certified)
        ripple = 100.0 * (state.torque_highest - state.torque_lowest) / abs(state.torque)
        assert row.torque_ripple_percent == pytest.approx(ripple, rel=1e-12)


def test_a_current_beyond_the_limit_has_no_values():
    frame = frame_of("points", {"speed_rpm": (900.0,), "advance_deg": (30.0,), "current_a": (25.0, 27.0)})
    assert isfinite(frame["torque_mean_nm"][0])
    assert np.isnan(frame["torque_mean_nm"][1])


def test_a_parameter_changes_the_plant_it_belongs_to():
    axes = {
        "resistance": (1.0, 2.0),
        "supply_voltage_v": (40.0, 48.0),
        "speed_rpm": (900.0,),
        "advance_deg": (30.0,),
        "current_a": (15.0,),
    }
    frame = frame_of("points", axes)
    cold, hot = frame["copper_loss_w"][1], frame["copper_loss_w"][3]
    assert hot == pytest.approx(2.0 * cold, rel=0.2)
    assert frame["torque_mean_nm"][0] < frame["torque_mean_nm"][1], "less voltage must give less torque here"


def test_the_map_of_the_best_is_the_oracle_and_nothing_where_no_angle_will_do():
    frame = frame_of("best", {"speed_rpm": (700.0, 1500.0), "torque_nm": (9.8, 20.0)})
    drive = load_drive("paper-5-phase").plant()
    first = frame.iloc[0]
    best = least_current_sum(drive, 700.0 * pi / 30.0, 9.8)
    # The speed has gone through rpm, which may cost its last digit.
    assert first["current_sum_a"] == pytest.approx(best.current_sum, rel=1e-12)
    assert first["advance_deg"] == pytest.approx(np.degrees(best.advance))
    edge = feasible_edge(drive, 1500.0 * pi / 30.0, 9.8)
    assert frame["edge_deg"][2] == pytest.approx(np.degrees(edge))
    assert frame.iloc[3].drop(["speed_rpm", "torque_nm"]).isna().all(), "20 N·m cannot be had at 1500 rpm"
    assert 0.85 < first["efficiency"] < 1.0


def test_a_candidate_is_judged_against_the_best_at_every_point():
    axes = {"speed_rpm": (700.0, 1500.0), "torque_nm": (9.8, 20.0)}
    reference = frame_of("loop", axes, resolve_candidate("reference"))
    assert reference["verdict"].tolist() == ["converged", "converged", "converged", "not feasible"]
    assert reference["excess_percent"][:3].max() < 2.0
    assert reference.iloc[3].drop(["speed_rpm", "torque_nm", "verdict"]).isna().all()
    published = frame_of(
        "loop", {"speed_rpm": (1500.0,), "torque_nm": (9.8,)}, resolve_candidate("published")
    )
    assert published["verdict"].tolist() == ["not converged"], "Fig. 4 taken literally locks up here"


def test_below_base_speed_a_point_must_be_had_without_advance():
    frame = frame_of("loop", {"speed_rpm": (450.0,), "torque_nm": (10.0, 24.0)}, resolve_candidate("initial"))
    assert frame["verdict"].tolist() == ["converged", "not feasible"]
    assert frame["advance_deg"][0] == 0.0
    assert np.isnan(frame["least_current_sum_a"][0])


def test_a_fault_of_the_candidate_is_a_verdict_at_its_point(tmp_path):
    (tmp_path / "own.py").write_text(
        "from drivegate import Command\n"
        "class Mine:\n"
        "    def reset(self, nameplate): pass\n"
        "    def step(self, sense):\n"
        "        if sense.speed_reference > 120: raise ValueError('too fast')\n"
        "        return Command(current_reference=5.0, advance_angle=0.0)\n",
        encoding="utf-8",
    )
    axes = {"speed_rpm": (1000.0, 1300.0), "torque_nm": (2.0,)}
    frame = frame_of("loop", axes, resolve_candidate(f"{tmp_path}/own.py:Mine"))
    assert frame["verdict"].tolist() == ["not converged", "exception"]
    assert frame["current_sum_a"].isna().tolist() == [False, True]


def test_no_worker_outlives_a_map():
    frame_of("points", {"speed_rpm": (300.0,), "advance_deg": (0.0, 9.0), "current_a": (5.0,)}, workers=2)
    # What keeps account of joblib's shared memory stays until this process ends.
    children = psutil.Process().children(recursive=True)
    alive = [child for child in children if child.status() != psutil.STATUS_ZOMBIE]
    names = [" ".join(child.cmdline()) for child in alive]
    assert [name for name in names if "LokyProcess" in name] == []


@pytest.mark.nightly
def test_the_command_writes_the_same_files_whatever_the_workers(command, tmp_path):
    axes = ("--speed-rpm", "400:2000:41", "--advance-deg", "0:90:46", "--current-a", "6:26:11")
    files = ("--parquet", "map.parquet", "--csv", "map.csv", "--plot", "map.svg")
    code, out, err = command(*axes, "--workers", 1, *files, "--json")
    assert code == 0, err
    document = json.loads(out)
    assert document["points"] == 41 * 46 * 11
    first = {name: (tmp_path / name).read_bytes() for name in files[1::2]}
    code, _, err = command(*axes, "--workers", 2, *files)
    assert code == 0, err
    assert {name: (tmp_path / name).read_bytes() for name in files[1::2]} == first
    frame = pandas.read_parquet(tmp_path / "map.parquet")
    assert len(frame) == document["points"]
    assert frame["torque_mean_nm"].max() == document["ranges"]["torque_mean_nm"]["highest"]
    assert pandas.read_csv(tmp_path / "map.csv").shape == frame.shape
    assert "<svg" in (tmp_path / "map.svg").read_text(encoding="utf-8")


@pytest.mark.nightly
def test_a_map_of_one_row_is_drawn_as_lines(command, tmp_path):
    code, out, err = command("--speed-rpm", "1500", "--torque-nm", "2:9.8:3", "--plot", "map.png")
    assert code == 0, err
    assert "the best of paper-5-phase: 3 points" in out
    assert (tmp_path / "map.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("--speed-rpm", "fast"), "--speed-rpm: it is \"fast\", but must be LOW:HIGH:COUNT"),
        (("--speed-rpm", "100:50:3"), "must be LOW:HIGH:COUNT"),
        (("--speed-rpm", "0:50:3"), "it has 0, but must be above 0"),
        (("--speed-rpm", "5,5"), "has a value twice"),
        (("--advance-deg", "0:91:3"), "it has 91, but must be from 0 to 90"),
        (("--speed-rpm", "1:2:20000000"), "a COUNT from 2 to 100000"),
        (("--speed-rpm", "1:2:100000", "--current-a", "1:2:9"), "must have at most 20000000"),
        (("--parameter", "resistanc=1,2"), "the nearest is 'resistance'"),
        (("--parameter", "resistance"), "is written KEY=LOW:HIGH:COUNT"),
        (("--parameter", "resistance=-1"), "'resistance' is -1.0"),
        (("--parameter", "resistance=1", "--parameter", "resistance=2"), "the same key twice"),
        (("--torque-nm", "5", "--current-a", "5"), "go with a map of the plant"),
        (("referense",), "the nearest known one is 'reference'"),
        (("--csv", "missing/map.csv"), "its folder does not exist"),
        (("--plot", "map.pdf"), "must end in .png or .svg"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_reported_in_one_sentence(command, tmp_path, words, reason):
    code, out, err = command(*words)
    assert code == 2, err
    assert out == ""
    (sentence,) = [line for line in err.splitlines() if line.startswith("error: ")]
    assert reason in sentence
    assert list(tmp_path.iterdir()) == []


def test_axes_are_ranges_lists_or_numbers():
    read = axis_within(0.0, 100.0)
    assert read("0:100:3") == (0.0, 50.0, 100.0)
    assert read("7,3") == (7.0, 3.0)
    assert read("42") == (42.0,)
    assert parameter_axis("inductance=0.8:1.2:3", ("inductance",)) == ("inductance", (0.8, 1.0, 1.2))
    for wrong in ("", "1:2", "1:2:1", "1:2:3:4", "nan", "inf:1:2", "1,,2"):
        with pytest.raises(InputError):
            read(wrong)
