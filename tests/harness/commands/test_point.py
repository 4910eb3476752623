"""`drivegate point`: its values, and every kind of bad input."""

import math

import pytest

from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.steady.oracle import point_at_torque
from drivegate_models.steady.steady_state import steady_state

KEYS = [
    "schema",
    "speed_rpm",
    "advance_deg",
    "current_reference_a",
    "feasible",
    "torque_mean_nm",
    "torque_lowest_nm",
    "torque_highest_nm",
    "torque_ripple_percent",
    "torque_ripple_one_sided_percent",
    "current_sum_a",
    "exchanged_power_w",
    "input_power_w",
    "copper_loss_w",
    "core_loss_w",
    "current_peak_a",
]
AT_1500 = ("point", "--speed-rpm", "1500", "--advance-deg", "52.5")
SPEED = 1500 * math.pi / 30


@pytest.fixture(scope="module")
def drive():
    return load_drive("paper-5-phase").plant()


def test_at_a_torque_the_document_is_the_oracles_point(command, drive):
    ended = command(*AT_1500, "--torque-nm", "9.8", "--json")
    point = point_at_torque(drive, SPEED, math.radians(52.5), 9.8)
    document = ended.document
    assert ended.code == 0
    assert ended.err == ""
    assert list(document)[: len(KEYS)] == KEYS
    assert document["feasible"] is True
    assert document["current_reference_a"] == point.reference
    assert document["input_power_w"] == point.input_power
    assert (
        document["torque_ripple_percent"] == 100 * (point.torque_highest - point.torque_lowest) / point.torque
    )


def test_at_a_current_the_document_is_the_steady_state(command, drive):
    document = command(*AT_1500, "--current-a", "11.3", "--json").document
    state = steady_state(drive, SPEED, 11.3, math.radians(52.5))
    assert document["torque_mean_nm"] == state.torque
    assert document["input_power_w"] == state.source_power + state.core_source_power + state.switching_loss
    worst = max(state.torque_highest - state.torque, state.torque - state.torque_lowest)
    assert document["torque_ripple_one_sided_percent"] == 100 * worst / state.torque


def test_cycles_from_rest_come_to_the_ideal_regulators_steady_state(command):
    ideal = ("--current-a", "11.3", "--set", "hysteresis_band_a=0", "--json")
    settled = command(*AT_1500, *ideal).document
    from_rest = command(*AT_1500, *ideal, "--cycles", "30").document
    assert settled["certified"] is True
    assert from_rest["averaged_cycles"] == 1
    for key in KEYS[5:]:
        assert from_rest[key] == pytest.approx(settled[key], rel=1e-8), f"{key} must settle"


def test_out_of_reach_it_gives_the_values_at_the_limit(command):
    beyond = command("point", "--speed-rpm", 1500, "--advance-deg", 45, "--torque-nm", 9.8, "--json").document
    at_limit = command(
        "point", "--speed-rpm", 1500, "--advance-deg", 45, "--current-a", 26, "--json"
    ).document
    assert (beyond["feasible"], at_limit["feasible"]) == (False, True)
    assert {key: beyond[key] for key in KEYS if key != "feasible"} == {
        key: at_limit[key] for key in KEYS if key != "feasible"
    }
    ended = command("point", "--speed-rpm", 1500, "--advance-deg", 45, "--torque-nm", 9.8)
    assert ended.code == 0
    assert "not feasible" in ended.out


def test_a_torque_that_only_less_than_the_limit_gives_is_reported_in_plain_words(command):
    words = ("point", "--speed-rpm", 1000, "--advance-deg", 32, "--torque-nm", 14.324)
    stated = "13.9 A gives the torque, but a regulator at its limit may lose it"
    assert stated in command(*words).out
    document = command(*words, "--json").document
    assert document["reference_below_limit_a"] == pytest.approx(13.934, abs=1e-3)
    out_of_reach = command("point", "--speed-rpm", 1500, "--advance-deg", 45, "--torque-nm", 9.8)
    assert "gives the torque" not in out_of_reach.out


def test_a_current_above_the_limit_is_not_feasible(command):
    assert command(*AT_1500, "--current-a", "26.01", "--json").document["feasible"] is False


def test_the_ripple_of_no_torque_is_null(command):
    document = command("point", "--speed-rpm", 10, "--advance-deg", 0, "--current-a", 0, "--json").document
    assert document["torque_mean_nm"] == 0
    assert document["torque_ripple_percent"] is None
    assert document["torque_ripple_one_sided_percent"] is None


def test_people_get_a_table_with_units_and_what_to_do_next(command):
    text = command(*AT_1500, "--torque-nm", "9.8").out
    assert all(unit in text for unit in ("rpm", "N·m", "A", "W", "%"))
    assert "next: " in text


def test_a_drive_from_a_file_and_settings_on_top(command, tmp_path):
    (tmp_path / "mine.json").write_text(load_drive("paper-5-phase").to_json(), encoding="utf-8")
    plain = command(*AT_1500, "--current-a", 11, "--json").document
    same = command(*AT_1500, "--current-a", 11, "--drive", "mine.json", "--json").document
    other = command(
        *AT_1500, "--current-a", 11, "--drive", "mine.json", "--set", "resistance_ohm=0.16", "--json"
    )
    assert same == plain
    assert other.document["copper_loss_w"] > 1.5 * plain["copper_loss_w"]


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["--speed-rpm", "0"], "--speed-rpm"),
        (["--speed-rpm", "-5"], "above 0"),
        (["--speed-rpm", "nan"], "--speed-rpm"),
        (["--speed-rpm", "inf"], "--speed-rpm"),
        (["--speed-rpm", "1e6"], "up to 100000"),
        (["--speed-rpm", "fast"], "fast"),
        (["--speed-rpm", "1e-9"], "or more"),
        (["--advance-deg", "120"], "from 0 to 90"),
        (["--advance-deg", "-1"], "from 0 to 90"),
        (["--advance-deg", "NaN"], "from 0 to 90"),
        (["--current-a", "-1"], "--current-a"),
        (["--current-a", "nan"], "--current-a"),
        (["--torque-nm", "3"], "exactly one of --torque-nm and --current-a"),
        (["--cycles", "0"], "--cycles"),
        (["--cycles", "1.5"], "--cycles"),
        (["--cycles", "100001"], "--cycles"),
        (["--drive", "paper-5-fase"], "'paper-5-phase'"),
        (["--drive", "missing.toml"], "does not exist"),
        (["--set", "inductence_h=3e-3"], "'inductance_h'"),
        (["--set", "inductance_h=-3e-3"], "inductance_h"),
        (["--set", "inductance_h=nan"], "inductance_h"),
        (["--set", "inductance_h"], "KEY=VALUE"),
        (["--set", "emf_flat_deg=190"], "emf_flat_deg"),
        (["--set", "phases=5.5"], "phases"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(refused, words, reason):
    assert reason in refused(*AT_1500, "--current-a", "11", *words)


def test_neither_torque_nor_current_is_refused(refused):
    assert "exactly one" in refused(*AT_1500)


def test_cycles_go_with_a_current_only(refused):
    assert "--cycles" in refused(*AT_1500, "--torque-nm", "9.8", "--cycles", "3")


def test_a_missing_option_is_named(refused):
    assert "--advance-deg" in refused("point", "--speed-rpm", "1500", "--current-a", "3")


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"\x7fELF\x02\x01\xff\xfe\x00", "UTF-8"),
        (b"schema = 1\nname = ", "TOML"),
        (b"name = 'x'\n", "schema"),
        (b"schema = 99\n", "newer"),
        (b"schema = 1\n[machine]\nresistence_ohm = 1.0\n", "resistance_ohm"),
        (b"schema = 1\nresistance_ohm = 1.0\n", "belongs in the table [machine]"),
    ],
)
def test_a_file_that_is_no_drive_is_refused(refused, tmp_path, content, reason):
    (tmp_path / "drive.toml").write_bytes(content)
    assert reason in refused(*AT_1500, "--current-a", "11", "--drive", "drive.toml")


IDEAL_STAR = (
    *("point", "--drive", "star-3-phase", "--speed-rpm", 1500, "--torque-nm", 9.549, "--json"),
    *("--set", "hysteresis_band_a=0", "--set", "core_loss_conductance_s=0"),
)


@pytest.mark.parametrize(
    ("words", "ripple", "lowest", "highest", "current_sum", "copper"),
    [
        (("--advance-deg", 70.9), 52.6, 7.4, 12.5, 47.9, 47.7),
        (("--advance-deg", 70.3, "--set", "emf_flat_deg=150"), 110.8, 4.7, 15.2, 46.7, 45.8),
        (("--advance-deg", 46.45, "--set", "window_deg=150"), 14.7, 9.1, 10.5, 35.4, 25.1),
        (
            ("--advance-deg", 60, "--set", "emf_flat_deg=150", "--set", "inductance_h=0.000432"),
            *(204.3, -1.6, 17.9, 64.3, 86.3),
        ),
    ],
    ids=["packaged", "wide EMF", "wide windows", "changes its sign"],
)
def test_a_star_has_the_values_of_the_findings(command, words, ripple, lowest, highest, current_sum, copper):
    document = command(*IDEAL_STAR, *words).document
    # The table of docs/findings.md.
    keys = (
        "torque_ripple_percent",
        "torque_lowest_nm",
        "torque_highest_nm",
        "current_sum_a",
        "copper_loss_w",
    )
    found = [document[key] for key in keys]
    assert found == pytest.approx([ripple, lowest, highest, current_sum, copper], abs=0.06)


OFFSET_PERSISTS = (
    "--set", "resistance_ohm=0", "--set", "window_deg=180", "--set", "hysteresis_band_a=0", "--speed-rpm", "1500",
    "--advance-deg", "85",
)  # fmt: skip
"""A phase that always conducts, and whose current has room on both sides."""


@pytest.mark.parametrize(
    ("changes", "unique"),
    [
        (("--current-a", "26"), False),
        (("--torque-nm", "11"), True),
        (("--current-a", "10"), True),
        (("--current-a", "26", "--set", "resistance_ohm=0.08"), True),
        (("--current-a", "26", "--cycles", "3"), True),
        (("--current-a", "26", "--advance-deg", "50", "--set", "window_deg=144"), True),
    ],
)
def test_a_periodic_state_that_is_not_unique_is_said_to_be_so(command, changes, unique):
    words = ("point", *OFFSET_PERSISTS, *changes)
    assert command(*words, "--json").document["unique"] is unique
    stated = "the periodic state is not unique: without resistance" in command(*words).out
    assert stated is not unique


def test_a_star_without_resistance_and_drops_retains_an_offset_too(command):
    ideal = ("resistance_ohm=0", "switch_drop_v=0", "diode_drop_v=0", "hysteresis_band_a=0", "window_deg=180")
    settings = [f"--set={setting}" for setting in ideal]
    words = (
        "point",
        "--drive",
        "star-24v-3-phase",
        *settings,
        "--advance-deg",
        "80",
        "--current-a",
        "16",
        "--json",
    )
    assert command(*words, "--speed-rpm", "8000").document["unique"] is False
    assert command(*words, "--speed-rpm", "1500").document["unique"] is True
