"""`drivegate drive`: what a drive can do, in text, as JSON and as a figure."""

import io
import json
import re
from math import radians

import pytest
from rich.console import Console

from drivegate.drives.abilities import refuse_unreachable
from drivegate.results.result import finite
from drivegate.studies.drive.display import show_drive
from drivegate.studies.drive.run import studied_drive
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.errors import InputError
from drivegate_models.steady.steady_state import steady_state
from drivegate_models.units import RADIANS_PER_RPM

QUICK = ("--set", "hysteresis_band_a=0")
"""Without a band the steady states take a fraction of the time."""


@pytest.fixture(scope="module")
def document():
    return studied_drive(load_drive("paper-5-phase"))


def row_at(document, speed_rpm):
    return next(row for row in document["points"] if row["speed_rpm"] == speed_rpm)


def test_the_papers_drive_can_do_what_is_published(document):
    assert document["drive"] == "paper-5-phase"
    assert document["unreachable"] == []
    assert document["rating"] == {
        "base_speed_rpm": 500.0,
        "highest_speed_rpm": 1500.0,
        "overspeed_rpm": 2000.0,
        "rated_power_w": 1500.0,
        "current_limit_a": 26.0,
    }
    assert row_at(document, 500.0)["greatest_power_w"] == pytest.approx(1504.0, abs=1.0)
    # The table of docs/findings.md.
    edges = {700.0: 32.6, 900.0: 33.1, 1000.0: 33.2, 1200.0: 40.1, 1350.0: 46.2, 1500.0: 50.8, 2000.0: 57.9}
    found = {speed: row_at(document, speed)["edge_deg"] for speed in edges}
    assert found == pytest.approx(edges, abs=0.06)
    assert row_at(document, 1500.0)["ripple_percent"] == pytest.approx(13.9, abs=0.1)
    assert document["greatest_ripple_percent"] == pytest.approx(13.9, abs=0.1)
    assert document["rated_torque_without_advance_up_to_rpm"] == pytest.approx(340.0, abs=1.0)


def test_its_line_holds_rated_power_on_the_plant(document):
    line, drive = document["line"], load_drive("paper-5-phase").plant()
    for row in document["points"]:
        if not 550.0 <= row["speed_rpm"] <= 1500.0:
            continue
        angle = line["start_deg"] + line["slope_deg_per_rpm"] * (row["speed_rpm"] - 500.0)
        assert row["line_deg"] == pytest.approx(angle)
        given = steady_state(drive, row["speed_rpm"] * RADIANS_PER_RPM, 26.0, radians(angle)).torque
        assert given > row["rated_torque_nm"], f"at {row['speed_rpm']} rpm the line loses rated power"
        in_hand = 100.0 * (given / row["rated_torque_nm"] - 1.0)
        assert in_hand >= line["least_in_hand_percent"] - 1e-6
    assert line["least_in_hand_percent"] == pytest.approx(5.0, abs=0.3)
    assert row_at(document, 400.0)["line_deg"] == 0.0


def test_as_json_it_is_the_same_every_time(command, document):
    assert command("drive", "paper-5-phase", "--json").document == finite(document)


def test_people_get_a_table_the_line_the_times_and_what_to_do_next(command):
    ended = command("drive")
    assert ended.code == 0
    stated = (
        "paper-5-phase: 1500 W from 500 to 1500 rpm, 26 A",
        "line of initial angles: 0° below 500 rpm, then 32.9° + 0.02° per rpm above",
        "rated torque without advance: up to 340 rpm",
        "L/R 36 ms",
        "275 Hz at highest speed, so at most 0.914 ms",
        "next: the same with --plot drive.svg",
    )
    assert [words for words in stated if words not in ended.out] == []
    assert "35 of 35 speeds" in ended.err


def test_a_narrow_console_has_fewer_columns_and_no_broken_numbers(command, monkeypatch):
    for columns, heads in (("80", "rated"), ("160", "rated N·m")):
        monkeypatch.setenv("COLUMNS", columns)
        first, *listed = command("drive", *QUICK).out.splitlines()
        assert first.startswith("as a data sheet: link 96 V, 22 poles (pole_pairs = 11)")
        assert len(listed[2].rstrip()) <= int(columns)
        assert heads in listed[2]
        assert listed[4].split()[0] == "100"
        assert listed[5].split()[0] == "300", "each speed has a line of its own"


@pytest.mark.nightly
def test_a_rating_out_of_reach_is_named_and_shown_all_the_same(command):
    limited = ("drive", "--set", "current_limit_a=20")
    ended = command(*limited)
    assert ended.code == 2
    assert "a check refuses this drive: 1.5 kW needs 26.0 N·m at 550 rpm" in ended.out
    assert (
        "next: write rated_power_w = 1320 into the drive's file, or try it with --set rated_power_w=1320"
        in ended.out
    )
    document = command(*limited, "--json").document
    assert document["unreachable"][0]["message"] in ended.out
    assert row_at(document, 550.0)["edge_deg"] is None
    assert row_at(document, 550.0)["greatest_torque_nm"] > 20.0
    assert row_at(document, 1500.0)["edge_deg"] == pytest.approx(50.8, abs=0.1)


def test_where_a_unit_slipped_its_key_is_to_be_corrected_and_nothing_else(command):
    ended = command("drive", "pm-ac-servo", "--set", "resistance_ohm=2303")
    assert ended.code == 2
    last = ended.out.splitlines()[-1]
    assert last.startswith("next: correct resistance_ohm first, since the rest follows from it: ")
    assert "is it in milliohm" in last
    assert "rated_power_w = " not in ended.out
    with pytest.raises(
        InputError, match="correct resistance_ohm first, from which that may follow"
    ) as refused:
        refuse_unreachable(load_drive("pm-ac-servo").replaced(resistance_ohm=2303.0))
    assert "rated_power_w = " not in str(refused.value)


@pytest.mark.nightly
def test_torques_of_a_small_drive_keep_their_digits(command):
    small = ("drive", "fan-3-phase")
    document = command(*small, "--json").document
    at_highest = row_at(document, 6000.0)
    stated = command(*small).out
    assert f" {at_highest['rated_torque_nm']:.3f} " in stated
    assert f" {at_highest['greatest_torque_nm']:.3f} " in stated
    weak = command(*small, "--set", "current_limit_a=4").out
    assert (
        "100 W needs 0.434 N·m at 2200 rpm, but at the current limit of 4 A this drive delivers at most 0.301 N·m"
        in weak
    )


def test_speeds_of_a_slow_drive_keep_enough_digits_to_differ(command):
    slow = [
        *("machine.pole_pairs=52", "machine.magnet_flux_v_s=0.2", "machine.inertia_kg_m2=50"),
        *("rating.base_speed_rpm=17.8", "rating.highest_speed_rpm=19", "rating.overspeed_rpm=20.9"),
        "rating.rated_power_w=500",
    ]
    ended = command("drive", "pm-ac-surface", *(word for value in slow for word in ("--set", value)))
    speeds = [words[0] for line in ended.out.splitlines() if len(words := line.split()) == 11]
    shown = [speed for speed in speeds if speed.replace(".", "").isdigit()]
    assert len(shown) == len(set(shown)) == 14
    assert {"17.8", "19.0", "20.9"} < set(shown)


def test_a_current_that_is_zero_but_for_rounding_has_the_digits_of_the_others():
    drive = load_drive("pm-ac-surface")
    document = studied_drive(drive)
    for point in document["points"]:
        point["direct_a"] = point["greatest_direct_a"] = -7.3e-8
    shown = io.StringIO()
    show_drive(Console(file=shown, width=160), document | {"files": []}, "drive.toml", drive)
    assert "0.000" not in shown.getvalue()


def test_a_band_that_chops_too_often_is_reported_with_what_it_costs(command):
    shown = command("drive", "paper-5-phase", "--set", "hysteresis_band_a=0.001")
    assert "a check computes each chop, and takes long" in shown.out


def test_a_ripple_out_of_reach_leads_to_the_one_that_is_not(command):
    ended = command("drive", *QUICK, "--set", "ripple_percent=3")
    (row,) = command("drive", *QUICK, "--set", "ripple_percent=3", "--json").document["unreachable"]
    nearest = row["nearest_ripple_percent"]
    assert 3 < nearest < 20
    assert f"next: write ripple_percent = {nearest}, and closed_loop_ripple_percent above it" in ended.out
    assert "refuses" not in command("drive", *QUICK, "--set", f"ripple_percent={nearest}").out


def test_a_drive_that_can_do_nothing_of_its_rating_is_shown(command):
    ended = command("drive", *QUICK, "--set", "current_limit_a=2")
    assert ended.code == 2
    assert "line of initial angles: none" in ended.out
    document = command("drive", *QUICK, "--set", "current_limit_a=2", "--json").document
    assert document["line"]["start_deg"] is None
    assert document["time_scales"]["search_s"] is None


def test_a_drive_from_a_file_and_settings_on_top(command, tmp_path):
    own = load_drive("paper-5-phase").replaced(name="mine", base_speed_rpm=400.0)
    (tmp_path / "mine.json").write_text(own.to_json(), encoding="utf-8")
    ended = command("drive", "mine.json", "--set", "rated_power_w=1200", "--json")
    assert ended.code == 0
    assert ended.document["drive"] == "mine"
    assert ended.document["rating"]["highest_speed_rpm"] == pytest.approx(1500.0)
    assert ended.document["rating"]["rated_power_w"] == 1200.0


@pytest.mark.nightly
def test_the_figure_is_drawn_and_the_same_every_time(command, tmp_path):
    first = command("drive", *QUICK, "--plot", "drive.svg", "--json")
    assert first.document["files"] == ["drive.svg"]
    drawn = (tmp_path / "drive.svg").read_bytes()
    assert all(words in drawn.decode() for words in ("recommended line", "feasible edge", "torque ripple"))
    text = command("drive", *QUICK, "--plot", "drive.svg").out
    assert "written: drive.svg" in text
    assert "next: drivegate map reference --drive paper-5-phase" in text
    assert (tmp_path / "drive.svg").read_bytes() == drawn
    command("drive", *QUICK, "--set", "current_limit_a=2", "--plot", "drive.png")
    assert (tmp_path / "drive.png").read_bytes().startswith(b"\x89PNG")


def test_a_value_that_only_a_wrong_unit_explains_is_warned_of(command):
    assert "is it in millihenry?" in command("drive", "--set", "inductance_h=2.88").err


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["paper-5-fase"], "'paper-5-phase'"),
        (["missing.toml"], "does not exist"),
        (["--set", "inductence_h=3e-3"], "'inductance_h'"),
        (["--set", "rated_power_w=-1"], "rated_power_w"),
        (["--plot", "drive.pdf"], "must end in .png or .svg"),
        (["--plot", "missing/drive.svg"], "its folder does not exist"),
        (["--drive", "paper-5-phase"], "--drive"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(refused, words, reason):
    assert reason in refused("drive", *words)


def test_the_document_is_strict_json(command):
    text = command("drive", *QUICK, "--set", "resistance_ohm=0", "--json").out
    assert "NaN" not in text
    assert json.loads(text)["time_scales"]["electrical_s"] is None


PUBLISHED = "speed_rpm,advance_deg,torque_nm\n1500,52,9.8\n1200,40,11.88\n500,,28.648\n"


def test_constants_are_fitted_to_published_points_and_can_be_set_as_printed(command, tmp_path):
    (tmp_path / "published.csv").write_text(PUBLISHED, encoding="utf-8")
    words = ("drive", "--fit", "published.csv", "--keep", "resistance_ohm")
    ended = command(*words)
    assert ended.code == 0
    assert "nothing shows how sure they are" in ended.out
    assert "--set emf_constant_v_s_per_rad=0.33813 --set inductance_h=0.0028879" in ended.out
    printed = ended.out.split("next: drivegate ")[1].split()
    again = command(*printed, "--fit", "published.csv", "--keep", "resistance_ohm", "--json").document
    assert all(row["fitted"] == pytest.approx(row["stored"], rel=1e-4) for row in again["constants"])
    assert again["points"][2]["advance_deg"] is None
    assert again["points"][0]["fitted_torque_nm"] == pytest.approx(9.8)


@pytest.mark.nightly
def test_what_a_fit_cannot_show_is_stated(command, tmp_path):
    rows = "".join(f"5,0,{1.2 * current},{current}\n" for current in (1, 2, 3, 4, 5))
    (tmp_path / "slow.csv").write_text(f"speed_rpm,advance_deg,torque_nm,current_a\n{rows}", encoding="utf-8")
    ended = command("drive", *QUICK, "--fit", "slow.csv")
    stated = ended.out
    assert ended.code == 2
    assert "the points do not show resistance_ohm; keep it with --keep resistance_ohm" in stated
    assert "next: the same with more points" in stated


def test_a_fit_that_explains_nothing_says_so_and_proposes_nothing(command, tmp_path):
    rows = "".join(
        f"{speed},0,{torque}\n" for speed, torque in zip(range(100, 700, 100), [5, 20] * 3, strict=True)
    )
    (tmp_path / "other.csv").write_text(f"speed_rpm,advance_deg,torque_nm\n{rows}", encoding="utf-8")
    ended = command("drive", *QUICK, "--fit", "other.csv")
    assert ended.code == 2
    assert "no constants explain these torques: the best fit leaves" in ended.out
    assert "--set" not in ended.out


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["--fit", "missing.csv"], "does not exist; name an existing CSV file"),
        (["--keep", "resistance_ohm"], "--keep goes with --fit only"),
        (["--fit", "any.csv", "--plot", "drive.svg"], "--plot and --fit do not go together"),
    ],
)
def test_a_fit_that_cannot_be_is_refused_in_one_sentence(refused, words, reason):
    assert reason in refused("drive", *words)


def test_a_pm_ac_drive_is_reported_by_its_limits_of_current_and_voltage(command, tmp_path):
    plot = tmp_path / "drive.svg"
    document = command("drive", "pm-ac-interior", "--plot", str(plot), "--json").document
    assert document["unreachable"] == []
    assert plot.is_file()
    # What is known of this machine (tests of its oracle): it uses up its voltage at 2168.7 rpm.
    assert document["voltage_used_up_at_rpm"] == pytest.approx(2168.7, abs=0.1)
    assert document["magnet_current_a"] > document["rating"]["current_limit_a"]
    at_base = row_at(document, 2100.0)
    assert at_base["greatest_power_w"] == pytest.approx(556.1, abs=0.1)
    assert all(row["least_loss_w"] <= row["loss_w"] * (1.0 + 1e-9) for row in document["points"])
    best = document["trajectories"]["most_torque_per_ampere"][-1]
    assert best["current_a"] == pytest.approx(document["rating"]["current_limit_a"])
    assert max(value for row in document["efficiency_map"]["efficiency_percent"] for value in row) < 95.0
    drawn = plot.read_text(encoding="utf-8")
    for words in ("d current (A)", "efficiency at least loss (%)", "most torque"):
        assert words in drawn, f"the figure does not tell {words}"
    shown = command("drive", "pm-ac-interior").out
    assert "2168.7 rpm" in shown
    assert "best efficiency" in shown
    much = command("drive", "pm-ac-interior", "--set", "rated_power_w=900", "--json").document
    assert "900 W needs 4.09 N·m at 2100 rpm" in much["unreachable"][0]["message"]


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("name", "changes", "value"),
    [
        ("pm-ac-interior", {"rated_power_w": 900.0}, "rated_power_w = 511"),
        ("pm-ac-interior", {"inertia_kg_m2": 0.3}, "inertia_kg_m2 = "),
        ("fan-3-phase", {"current_limit_a": 4.0, "hysteresis_band_a": 0.0}, "rated_power_w = "),
    ],
)
def test_what_a_check_refuses_is_shown_with_the_value_to_write_and_no_check_is_recommended(
    command, refused, tmp_path, name, changes, value
):
    own = load_drive(name).replaced(**changes)
    (tmp_path / "mine.json").write_text(own.to_json(), encoding="utf-8")
    candidate = "foc" if own.kind == "pm-ac" else "reference"
    sentence = refused("check", candidate, "--drive", "mine.json")
    ended = command("drive", "mine.json", "--plot", "drive.svg")
    assert ended.code == 2
    assert f"next: write {value}" in ended.out
    assert "drivegate check" not in ended.out
    reason = re.split(r"requires: |checked: ", sentence)[-1]
    assert f"a check refuses this drive: {reason}" in ended.out


def test_values_that_follow_from_a_data_sheet_are_shown_with_what_they_follow_from(command, tmp_path):
    mapping = load_drive("pm-ac-interior").to_mapping()
    mapping["rating"] |= {"continuous_current_a": 5.0, "peak_current_a": 10.0}
    del mapping["rating"]["rated_power_w"], mapping["rating"]["current_limit_a"]
    (tmp_path / "sheet.json").write_text(json.dumps(mapping), encoding="utf-8")
    ended = command("drive", "sheet.json")
    assert ended.code == 0
    assert "from the data sheet: current_limit_a = 10 follows from peak_current_a" in ended.out
    document = command("drive", "sheet.json", "--json").document
    rows = {row["key"]: row for row in document["following"]}
    assert rows["rated_power_w"]["value"] == document["rating"]["rated_power_w"]
    assert (
        f"rated_power_w = {rows['rated_power_w']['value']:g} follows from continuous_current_a" in ended.out
    )
    assert command("drive", "pm-ac-interior", "--json").document["following"] == []
