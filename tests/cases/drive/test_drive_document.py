import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import PM_AC, DriveDocument, drive_names, load_drive
from drivegate_cases.drive.plant import Scales
from drivegate_models.steady.torque_limit import torques_at_limit
from drivegate_models.units import RADIANS_PER_RPM

PAPER = load_drive("paper-5-phase")


@pytest.mark.parametrize("name", drive_names())
def test_every_drive_of_the_package_loads_and_says_where_its_values_come_from(name: str) -> None:
    drive = load_drive(name)
    assert drive.name == name
    explained = {key: sentence for table in drive.provenance.values() for key, sentence in table.items()}
    tables = (drive.machine, drive.inverter, drive.rating, drive.advance, drive.requirements)
    stated = {key for table in tables if table is not None for key in table.model_fields_set}
    unexplained = stated - set(explained)
    assert not unexplained, f"{name} has values without provenance: {sorted(unexplained)}"
    for key, sentence in explained.items():
        assert sentence.startswith(("stated:", "calibrated:", "assumed:")), f"{key}: {sentence}"


def test_the_paper_drive_has_the_published_values() -> None:
    assert (PAPER.machine.phases, PAPER.machine.pole_pairs, PAPER.inverter.window_deg) == (5, 11, 144.0)
    assert (PAPER.inverter.supply_voltage_v, PAPER.rating.base_speed_rpm) == (48.0, 500.0)
    assert (PAPER.rating.rated_power_w, PAPER.rating.current_limit_a) == (1500.0, 26.0)


def test_a_drive_is_loaded_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "mine.json"
    path.write_text(PAPER.replaced(name="mine").to_json())
    assert load_drive(str(path)) == load_drive("mine.json", relative_to=tmp_path)
    assert load_drive(path).name == "mine"


@pytest.mark.parametrize("name", ["paper-5-phas", "", "../drives", "paper\n", "paper-5-phase.toml", "x.yaml"])
def test_an_unknown_drive_is_refused(refusal: Callable[..., str], name: str) -> None:
    refusal(load_drive, name)


def test_an_unknown_name_is_reported_with_what_there_is(refusal: Callable[..., str]) -> None:
    message = refusal(load_drive, "paper-3-phase")
    assert "no drive is called 'paper-3-phase', the nearest is 'paper-5-phase'" in message


@pytest.mark.parametrize(
    ("pairs", "reported"),
    [
        (["inductance_h=0"], "the key 'machine.inductance_h' is 0, but must be greater than 0"),
        (["inductance_h=-1", "phases=0"], "; "),
        (["resistance_ohm=-0.1"], "the key 'machine.resistance_ohm'"),
        (["resistance_ohm=nan"], "must be a finite number"),
        (["inertia_kg_m2=inf"], "must be a finite number"),
        (["inertia_kg_m2=0"], "the key 'machine.inertia_kg_m2'"),
        (["phases=32"], "the key 'machine.phases' is 32"),
        (["phases=5.5"], "the key 'machine.phases' is 5.5"),
        (["pole_pairs=0"], "the key 'machine.pole_pairs'"),
        (["pole_pairs=201"], "the key 'machine.pole_pairs'"),
        (["window_deg=0"], "the key 'inverter.window_deg'"),
        (["window_deg=180.1"], "the key 'inverter.window_deg'"),
        (["emf_flat_deg=180"], "the key 'machine.emf_flat_deg' is 180, but must be less than 180"),
        (["emf_flat_deg=-1"], "the key 'machine.emf_flat_deg'"),
        (["emf_flat_deg=null"], "the key 'emf_flat_deg' is missing"),
        (["emf_shape=square"], "must be 'trapezoid', 'sine' or 'table'"),
        (["emf_shape=table"], "the key 'emf_table' is missing"),
        (
            ["emf_shape=sine", "emf_flat_deg=90"],
            "'emf_flat_deg' is for the shape \"trapezoid\", but the key 'emf_shape' is",
        ),
        (["emf_table=[[0,0],[90,1],[180,0]]"], "the key 'emf_table' is for the shape \"table\""),
        (["emf_table=[[0,0],[90,0.5],[180,0]]"], "the key 'machine.emf_table'"),
        (["emf_table=[[0,0],[90],[180,0]]"], "the key 'machine.emf_table[1]'"),
        (["current_limit_a=0"], "the key 'rating.current_limit_a'"),
        (["supply_voltage_v=0"], "the key 'inverter.supply_voltage_v'"),
        (["core_loss_conductance_s=-1"], "the key 'machine.core_loss_conductance_s'"),
        (["friction_n_m=-1"], "the key 'machine.friction_n_m'"),
        (["viscous_friction_n_m_s_per_rad=-1"], "the key 'machine.viscous_friction_n_m_s_per_rad'"),
        (["switch_drop_v=48"], "the key 'switch_drop_v' is 48.0, but must be below the supply's 48.0 V"),
        (["diode_drop_v=-0.1"], "the key 'inverter.diode_drop_v'"),
        (["turn_on_energy_j=-1"], "the key 'inverter.turn_on_energy_j'"),
        (["turn_off_energy_j=1e9"], "the key 'inverter.turn_off_energy_j'"),
        (["hysteresis_band_a=0.0009"], "must be 0 for the ideal regulator, or at least 0.001"),
        (["hysteresis_band_a=-1"], "the key 'inverter.hysteresis_band_a'"),
        (["inductance_h=1e-6"], "the key 'inverter.hysteresis_band_a' is 0.25, but with this supply"),
        (["base_speed_rpm=fast"], "the key 'rating.base_speed_rpm' is \"fast\", but must be a number"),
        (["rated_power_w=0"], "the key 'rating.rated_power_w'"),
        (["indutance_h=1"], "the key 'indutance_h' is unknown, the nearest known key is 'inductance_h'"),
        (["machine.indutance_h=1"], "the nearest known key is 'machine.inductance_h'"),
        (["inverter.inductance_h=1"], "the key 'inverter.inductance_h' is unknown"),
        (["kind=star"], "the key 'kind' is unknown"),
        (["highest_speed_rpm=500"], "is 500, but must be above the base speed of 500 rpm"),
        (
            ["base_speed_rpm=1600"],
            "'highest_speed_rpm' is 1500, but must be above the base speed of 1600 rpm",
        ),
        (["overspeed_rpm=1400"], "is 1400, but must be at least the highest speed of 1500 rpm"),
        (["hysteresis_band_a=27"], "is 27, but must be at most the current limit of 26 A"),
        (["start_deg=91"], "the key 'advance.start_deg' is 91"),
        (["resistance_ohm=1e300"], "the key 'machine.resistance_ohm' is 1e+300, but must be"),
        (["schema=2"], "the key 'schema' is unknown"),
        (["provenance=x"], "the key 'provenance' is unknown"),
    ],
)
def test_a_wrong_setting_is_reported(refusal: Callable[..., str], pairs: list[str], reported: str) -> None:
    message = refusal(PAPER.with_overrides, pairs)
    assert message.startswith("--set ")
    assert reported in message


def test_settings_change_what_they_name_and_say_so() -> None:
    drive = PAPER.with_overrides(["phases=3", "emf_shape=sine", "inductance_h=1e-3"])
    assert (drive.machine.phases, drive.machine.emf_shape, drive.machine.inductance_h) == (3, "sine", 1e-3)
    assert drive.provenance["machine"]["phases"] == "set on the command line"
    assert drive.provenance["machine"]["resistance_ohm"] == PAPER.provenance["machine"]["resistance_ohm"]
    assert PAPER.machine.phases == 5, "the original changed"


def test_no_settings_change_nothing() -> None:
    assert PAPER.with_overrides([]) == PAPER


@pytest.mark.parametrize("band", ["0", "0.001", "26"])
def test_the_ideal_regulator_and_ordinary_bands_are_valid(band: str) -> None:
    assert PAPER.with_overrides(
        [f"hysteresis_band_a={band}", "inductance_h=0.1"]
    ).inverter.hysteresis_band_a == float(band)


def test_the_chopping_limit_lies_where_it_is_said() -> None:
    narrowest = 48.0 / (2.0 * 1e-6 * 10e6)
    drive = PAPER.with_overrides(["inductance_h=1e-6", f"hysteresis_band_a={narrowest * 1.0001}"])
    assert drive.inverter.hysteresis_band_a > narrowest


def test_provenance_is_of_known_keys_only(refusal: Callable[..., str]) -> None:
    for provenance, reported in (
        ({"colour": {"paint": "assumed: grey"}}, '"colour" is no table of a drive'),
        ({"machine": {"colour": "assumed: grey"}}, "\"colour\" is no key of the table 'machine'"),
        ({"machine": {"window_deg": "assumed"}}, "\"window_deg\" is no key of the table 'machine'"),
        ({"machine": "assumed"}, "the key 'provenance.machine' is \"assumed\", but must be a table"),
    ):
        mapping = PAPER.to_mapping() | {"provenance": provenance}
        assert reported in refusal(parse_document, mapping, DriveDocument, "here")


@pytest.mark.parametrize(
    "provenance",
    [
        {"machine": {"phases": "x" * 10_000_000}},
        {"machine": {"x" * 10_000_000: "assumed"}},
        {"x" * 10_000_000: {"phases": "assumed"}},
        {"machine": {f"key {number}": "assumed" for number in range(100_000)}},
    ],
    ids=["a long sentence", "a long key", "a long table", "many keys"],
)
def test_a_huge_provenance_is_refused_in_a_short_sentence(
    refusal: Callable[..., str], provenance: dict[str, Any]
) -> None:
    mapping = PAPER.to_mapping() | {"provenance": provenance}
    assert len(refusal(parse_document, mapping, DriveDocument, "here")) < 500


@pytest.mark.parametrize("name", ["paper-5-phase", "pm-ac-surface"])
@pytest.mark.parametrize(
    ("kind", "closest"),
    [("pmac", "; the nearest is 'pm-ac'"), ("half_bridge", "; the nearest is 'half-bridge'"), (5, "")],
)
def test_a_kind_that_there_is_not_is_refused_with_those_that_there_are(
    refusal: Callable[..., str], name: str, kind: object, closest: str
) -> None:
    mapping = load_drive(name).to_mapping() | {"kind": kind}
    message = refusal(parse_document, mapping, DriveDocument, "here")
    words = f"the key 'kind' is {json.dumps(kind)}, but must be 'half-bridge', 'star' or 'pm-ac'{closest}"
    if isinstance(kind, str):
        assert message == f"here: {words}", "a slip in the kind must not be followed by one for each key"
    else:
        assert words in message


def test_keys_of_another_kind_are_unknown(refusal: Callable[..., str]) -> None:
    mapping = PAPER.to_mapping()
    mapping["inverter"]["carrier_hz"] = 8000.0
    assert "the key 'inverter.carrier_hz' is unknown" in refusal(
        parse_document, mapping, DriveDocument, "here"
    )


def test_a_key_outside_of_its_table_is_refused(refusal: Callable[..., str]) -> None:
    mapping = PAPER.to_mapping() | {"phases": 5}
    message = refusal(parse_document, mapping, DriveDocument, "here")
    assert message.endswith("the key 'phases' belongs in the table [machine]")
    mapping = PAPER.to_mapping()
    mapping["rating"]["window_deg"] = 144.0
    message = refusal(parse_document, mapping, DriveDocument, "here")
    assert message.endswith("the key 'rating.window_deg' belongs in the table [inverter]")


def test_a_key_may_be_named_with_its_table() -> None:
    assert PAPER.with_overrides(["machine.phases=3"]) == PAPER.with_overrides(["phases=3"])


def test_equal_drives_have_equal_hashes() -> None:
    again = parse_document(PAPER.to_mapping(), DriveDocument, "here")
    assert again == PAPER
    assert hash(again) == hash(PAPER)
    assert hash(PAPER.replaced(phases=3)) != hash(PAPER)


@given(
    st.integers(1, 31),
    st.integers(1, 200),
    st.floats(0.0, 1e4),
    st.floats(1e-4, 1e2),
    st.floats(0.0, 180.0, exclude_max=True),
)
def test_a_drive_survives_a_round_trip(
    phases: int, pole_pairs: int, resistance: float, inductance: float, flat: float
) -> None:
    drive = PAPER.replaced(
        phases=phases,
        pole_pairs=pole_pairs,
        resistance_ohm=resistance,
        inductance_h=inductance,
        hysteresis_band_a=0.25,
        emf_flat_deg=flat,
    )
    again = parse_document(json.loads(drive.to_json()), DriveDocument, "there")
    assert again == drive
    assert again.to_json() == drive.to_json()


def test_the_plant_gets_si_units_and_the_scales() -> None:
    drive = PAPER.with_overrides(["friction_n_m=0.1", "window_deg=120"])
    scales = Scales(resistance=2.0, inductance=1.2, emf_constant=0.95, friction_added_n_m=0.5)
    plant = drive.plant(scales)
    assert plant.resistance == pytest.approx(2.0 * drive.machine.resistance_ohm)
    assert plant.inductance == pytest.approx(1.2 * drive.machine.inductance_h)
    assert plant.emf_constant == pytest.approx(0.95 * drive.machine.emf_constant_v_s_per_rad)
    assert plant.friction == pytest.approx(0.6)
    assert plant.window == pytest.approx(2.0 * math.pi / 3.0)
    assert plant.half_supply_voltage == 48.0


def test_the_nominal_plant_is_the_unscaled_one() -> None:
    drive = PAPER.plant()
    assert drive.resistance == PAPER.machine.resistance_ohm
    assert drive.inductance == PAPER.machine.inductance_h


@pytest.mark.parametrize(
    ("pairs", "angle", "value"),
    [
        (["emf_shape=trapezoid", "emf_flat_deg=100"], 40.0, 1.0),
        (["emf_shape=trapezoid", "emf_flat_deg=100"], 20.0, 0.5),
        (["emf_shape=sine"], 30.0, 0.5),
        (["emf_shape=table", "emf_table=[[0,0],[60,1],[180,0]]"], 120.0, 0.5),
        (["emf_shape=table", "emf_table=[[0,0],[60,1],[180,0]]"], 300.0, -0.5),
    ],
)
def test_each_shape_reaches_the_plant(pairs: list[str], angle: float, value: float) -> None:
    drive = PAPER.with_overrides(pairs).plant()
    got = np.interp(math.radians(angle), drive.emf_angles, drive.emf_values)
    assert got == pytest.approx(value, abs=2e-4), f"the shape is {got} at {angle} deg, but should be {value}"


def test_the_nameplate_is_nominal_and_in_si_units() -> None:
    nameplate = PAPER.nameplate(0.0005)
    assert nameplate.base_speed == pytest.approx(500.0 * 2.0 * math.pi / 60.0)
    assert nameplate.control_period == 0.0005
    assert nameplate.resistance == PAPER.machine.resistance_ohm
    assert (nameplate.phases, nameplate.pole_pairs, nameplate.current_limit) == (5, 11, 26.0)


def test_the_nameplate_of_the_paper_drive_has_the_numbers_of_the_first_controllers_bit_for_bit() -> None:
    nameplate = PAPER.nameplate(0.0005)
    assert (nameplate.kind, nameplate.conducting_phases) == (1, 0.8 * nameplate.phases)
    assert nameplate.window == math.radians(144.0)
    assert nameplate.advance_start == math.radians(33.0)
    assert nameplate.advance_slope == math.radians(0.025) * 30.0 / math.pi
    assert nameplate.highest_speed == pytest.approx(1500.0 * math.pi / 30.0, rel=1e-15)


def test_half_a_line_of_angles_is_refused(refusal: Callable[..., str]) -> None:
    message = refusal(PAPER.replaced(advance=None).with_overrides, ["start_deg=10"])
    assert "the key 'advance.slope_deg_per_rpm' is missing" in message


def test_a_line_that_is_left_out_is_computed_and_keeps_rated_power() -> None:
    drive = PAPER.replaced(advance=None)
    nameplate = drive.nameplate(0.0005)
    plant = drive.plant()
    for speed in np.linspace(nameplate.base_speed, nameplate.highest_speed, 7):
        angle = nameplate.advance_start + nameplate.advance_slope * (speed - nameplate.base_speed)
        torque = torques_at_limit(plant, float(speed), [angle])[0]
        assert torque * speed >= 0.999 * nameplate.rated_power, (
            f"at {speed:.1f} rad/s and {math.degrees(angle):.1f} deg the drive gives {torque * speed:.0f} W"
        )


def test_a_drive_out_of_reach_of_its_rated_power_has_no_line(refusal: Callable[..., str]) -> None:
    drive = PAPER.replaced(advance=None, rated_power_w=15e3)
    assert "no line of angles can be computed" in refusal(drive.nameplate, 0.0005)
    assert PAPER.replaced(rated_power_w=15e3).nameplate(0.0005).rated_power == 15e3, (
        "a stated line is not computed"
    )


@pytest.mark.parametrize("name", drive_names(but=PM_AC))
def test_each_packaged_drive_keeps_rated_power_along_its_line(name: str) -> None:
    drive = load_drive(name)
    nameplate, plant = drive.nameplate(0.0005), drive.plant()
    for speed in np.linspace(1.1 * nameplate.base_speed, nameplate.highest_speed, 7):
        line = nameplate.advance_start + nameplate.advance_slope * (speed - nameplate.base_speed)
        angle = min(line, 0.5 * math.pi)
        power = torques_at_limit(plant, float(speed), [angle])[0] * speed
        assert power >= nameplate.rated_power, (
            f"{name} gives {power:.5g} W at {speed / RADIANS_PER_RPM:.0f} rpm and {math.degrees(angle):.1f} deg"
        )


SCALED = [name for name in drive_names() if name != PAPER.name and load_drive(name).kind == PAPER.kind]


@pytest.mark.parametrize("name", SCALED)
def test_the_made_up_drives_have_the_shares_of_the_paper_drive(name: str) -> None:
    drive = load_drive(name)
    for key, of_paper in shares(PAPER).items():
        assert shares(drive)[key] == pytest.approx(of_paper, rel=0.05), (
            f"{key} of {name} breaks its scaling law"
        )


def shares(drive: DriveDocument) -> dict[str, float]:
    """Measure a drive by its own supply, current limit and base speed."""
    impedance = drive.inverter.supply_voltage_v / drive.rating.current_limit_a
    speed = drive.rating.base_speed_rpm * RADIANS_PER_RPM
    return {
        "resistance": drive.machine.resistance_ohm / impedance,
        "reactance": drive.machine.pole_pairs * speed * drive.machine.inductance_h / impedance,
        "emf": drive.machine.emf_constant_v_s_per_rad * speed / drive.inverter.supply_voltage_v,
        "core loss": drive.machine.core_loss_conductance_s * impedance,
        "mechanical time": drive.machine.inertia_kg_m2 * speed**2 / drive.rating.rated_power_w,
        "band": drive.inverter.hysteresis_band_a / drive.rating.current_limit_a,
        "window": drive.inverter.window_deg / 180.0 / (1.0 - 1.0 / drive.machine.phases),
    }
