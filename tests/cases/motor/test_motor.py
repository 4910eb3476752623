import json
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegate_cases.documents.document import parse_document
from drivegate_cases.motor.motor import SETTABLE_KEYS, Motor, load_motor, motor_names
from drivegate_cases.motor.scales import Scales

PAPER = load_motor("paper-5-phase")


@pytest.mark.parametrize("name", motor_names())
def test_every_motor_of_the_package_loads_and_says_where_its_values_come_from(name: str) -> None:
    motor = load_motor(name)
    assert motor.name == name
    unexplained = {
        key for key in SETTABLE_KEYS if key not in ("name", "emf_table") and key not in motor.provenance
    }
    assert not unexplained, f"{name} has values without provenance: {sorted(unexplained)}"
    for key, sentence in motor.provenance.items():
        assert sentence.startswith(("stated:", "calibrated:", "assumed:")), f"{key}: {sentence}"


def test_the_paper_motor_has_the_published_values() -> None:
    assert (PAPER.phases, PAPER.pole_pairs, PAPER.window_deg) == (5, 11, 144.0)
    assert (PAPER.supply_voltage_v, PAPER.base_speed_rpm) == (48.0, 500.0)
    assert (PAPER.rated_power_w, PAPER.current_limit_a) == (1500.0, 26.0)


def test_a_motor_is_loaded_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "mine.json"
    path.write_text(PAPER.replaced(name="mine").to_json())
    assert load_motor(str(path)) == load_motor("mine.json", beside=tmp_path)
    assert load_motor(path).name == "mine"


@pytest.mark.parametrize("name", ["paper-5-phas", "", "../motors", "paper\n", "paper-5-phase.toml", "x.yaml"])
def test_an_unknown_motor_is_refused(refusal: Callable[..., str], name: str) -> None:
    refusal(load_motor, name)


def test_an_unknown_name_is_reported_with_what_there_is(refusal: Callable[..., str]) -> None:
    message = refusal(load_motor, "paper-3-phase")
    assert "no motor is called 'paper-3-phase', the nearest is 'paper-5-phase'" in message


@pytest.mark.parametrize(
    ("pairs", "reported"),
    [
        (["inductance_h=0"], "the key 'inductance_h' is 0, but must be greater than 0"),
        (["inductance_h=-1", "phases=0"], "; "),
        (["resistance_ohm=-0.1"], "the key 'resistance_ohm'"),
        (["resistance_ohm=nan"], "must be a finite number"),
        (["inertia_kg_m2=inf"], "must be a finite number"),
        (["inertia_kg_m2=0"], "the key 'inertia_kg_m2'"),
        (["phases=32"], "the key 'phases' is 32"),
        (["phases=5.5"], "the key 'phases' is 5.5"),
        (["pole_pairs=0"], "the key 'pole_pairs'"),
        (["pole_pairs=201"], "the key 'pole_pairs'"),
        (["window_deg=0"], "the key 'window_deg'"),
        (["window_deg=180.1"], "the key 'window_deg'"),
        (["emf_flat_deg=180"], "the key 'emf_flat_deg' is 180, but must be less than 180"),
        (["emf_flat_deg=-1"], "the key 'emf_flat_deg'"),
        (["emf_flat_deg=null"], "the key 'emf_flat_deg' is missing"),
        (["emf_shape=square"], "must be 'trapezoid', 'sine' or 'table'"),
        (["emf_shape=table"], "the key 'emf_table' is missing"),
        (["emf_table=[[0,0],[90,0.5],[180,0]]"], "the key 'emf_table'"),
        (["emf_table=[[0,0],[90],[180,0]]"], "the key 'emf_table[1]'"),
        (["current_limit_a=0"], "the key 'current_limit_a'"),
        (["supply_voltage_v=0"], "the key 'supply_voltage_v'"),
        (["core_loss_conductance_s=-1"], "the key 'core_loss_conductance_s'"),
        (["friction_n_m=-1"], "the key 'friction_n_m'"),
        (["viscous_friction_n_m_s_per_rad=-1"], "the key 'viscous_friction_n_m_s_per_rad'"),
        (["switch_drop_v=48"], "the key 'switch_drop_v' is 48.0, but must be below the supply's 48.0 V"),
        (["diode_drop_v=-0.1"], "the key 'diode_drop_v'"),
        (["turn_on_energy_j=-1"], "the key 'turn_on_energy_j'"),
        (["turn_off_energy_j=1e9"], "the key 'turn_off_energy_j'"),
        (["hysteresis_band_a=0.0009"], "must be 0 for the ideal regulator, or at least 0.001"),
        (["hysteresis_band_a=-1"], "the key 'hysteresis_band_a'"),
        (["inductance_h=1e-6"], "the key 'hysteresis_band_a' is 0.25, but with this supply"),
        (["base_speed_rpm=fast"], "the key 'base_speed_rpm' is \"fast\", but must be a number"),
        (["rated_power_w=0"], "the key 'rated_power_w'"),
        (["indutance_h=1"], "the key 'indutance_h' is unknown, the nearest known key is 'inductance_h'"),
        (["schema=2"], "the key 'schema' is unknown"),
        (["provenance=x"], "the key 'provenance' is unknown"),
    ],
)
def test_a_wrong_setting_is_reported(refusal: Callable[..., str], pairs: list[str], reported: str) -> None:
    message = refusal(PAPER.with_overrides, pairs)
    assert message.startswith("--set ")
    assert reported in message


def test_settings_change_what_they_name_and_say_so() -> None:
    motor = PAPER.with_overrides(["phases=3", "emf_shape=sine", "inductance_h=1e-3"])
    assert (motor.phases, motor.emf_shape, motor.inductance_h) == (3, "sine", 1e-3)
    assert motor.provenance["phases"] == "set on the command line"
    assert motor.provenance["resistance_ohm"] == PAPER.provenance["resistance_ohm"]
    assert PAPER.phases == 5, "the original changed"


def test_no_settings_change_nothing() -> None:
    assert PAPER.with_overrides([]) == PAPER


@pytest.mark.parametrize("band", ["0", "0.001", "26"])
def test_the_ideal_regulator_and_ordinary_bands_are_valid(band: str) -> None:
    assert PAPER.with_overrides([f"hysteresis_band_a={band}", "inductance_h=0.1"]).hysteresis_band_a == float(
        band
    )


def test_the_chopping_limit_lies_where_it_is_said() -> None:
    narrowest = 48.0 / (2.0 * 1e-6 * 10e6)
    motor = PAPER.with_overrides(["inductance_h=1e-6", f"hysteresis_band_a={narrowest * 1.0001}"])
    assert motor.hysteresis_band_a > narrowest


def test_provenance_is_of_known_keys_only(refusal: Callable[..., str]) -> None:
    mapping = PAPER.to_mapping() | {"provenance": {"colour": "assumed: grey"}}
    assert "'colour' is no key of a motor" in refusal(parse_document, mapping, Motor, "here")


def test_equal_motors_have_equal_hashes() -> None:
    again = parse_document(PAPER.to_mapping(), Motor, "here")
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
@settings(deadline=None)
def test_a_motor_survives_a_round_trip(
    phases: int, pole_pairs: int, resistance: float, inductance: float, flat: float
) -> None:
    motor = PAPER.replaced(
        phases=phases,
        pole_pairs=pole_pairs,
        resistance_ohm=resistance,
        inductance_h=inductance,
        hysteresis_band_a=0.25,
        emf_flat_deg=flat,
    )
    again = parse_document(json.loads(motor.to_json()), Motor, "there")
    assert again == motor
    assert again.to_json() == motor.to_json()


def test_the_plant_gets_si_units_and_the_scales() -> None:
    motor = PAPER.with_overrides(["friction_n_m=0.1", "window_deg=120"])
    scales = Scales(resistance=2.0, inductance=1.2, emf_constant=0.95, friction_added_n_m=0.5)
    drive = motor.drive(scales)
    assert drive.resistance == pytest.approx(2.0 * motor.resistance_ohm)
    assert drive.inductance == pytest.approx(1.2 * motor.inductance_h)
    assert drive.emf_constant == pytest.approx(0.95 * motor.emf_constant_v_s_per_rad)
    assert drive.friction == pytest.approx(0.6)
    assert drive.window == pytest.approx(2.0 * math.pi / 3.0)
    assert drive.half_supply_voltage == 48.0


def test_the_nominal_plant_is_the_unscaled_one() -> None:
    drive = PAPER.drive()
    assert drive.resistance == PAPER.resistance_ohm
    assert drive.inductance == PAPER.inductance_h


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
    drive = PAPER.with_overrides(pairs).drive()
    got = np.interp(math.radians(angle), drive.emf_angles, drive.emf_values)
    assert got == pytest.approx(value, abs=2e-4), f"the shape is {got} at {angle} deg, but should be {value}"


def test_the_nameplate_is_nominal_and_in_si_units() -> None:
    nameplate = PAPER.nameplate(0.0005)
    assert nameplate.base_speed == pytest.approx(500.0 * 2.0 * math.pi / 60.0)
    assert nameplate.control_period == 0.0005
    assert nameplate.resistance == PAPER.resistance_ohm
    assert (nameplate.phases, nameplate.pole_pairs, nameplate.current_limit) == (5, 11, 26.0)
