"""Values of a drive that only a wrong unit explains: reported in one sentence, and no others."""

import pytest

from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.usual_values import unusual_values

PAPER = load_drive("paper-5-phase")
INTERIOR = load_drive("pm-ac-interior")


def changed(start=PAPER, /, **values):
    """Change values as no document could, where the rest of the drive does not fit them."""
    tables = {
        name: table.model_copy(update={key: value for key, value in values.items() if key in keys})
        for name in ("machine", "inverter", "rating")
        for table in [getattr(start, name)]
        for keys in [type(table).model_fields]
    }
    return start.model_copy(update=tables)


@pytest.mark.parametrize(
    ("key", "value", "asked"),
    [
        ("resistance_ohm", 300.0, "is it in milliohm?"),
        ("resistance_ohm", 8e-5, ""),
        ("inductance_h", 2.88, "is it in millihenry?"),
        ("inductance_h", 2880.0, "is it in microhenry?"),
        ("inductance_h", 2.88e-6, ""),
        ("emf_constant_v_s_per_rad", 35.5, "volts per 1000 turns a minute or millivolt seconds per radian?"),
        ("emf_constant_v_s_per_rad", 339.0, "volts per 1000 turns a minute or millivolt seconds per radian?"),
        ("inertia_kg_m2", 50.0, "is it in gram square metres or kilogram square centimetres?"),
        ("inertia_kg_m2", 5e-5, ""),
        ("supply_voltage_v", 48e3, "is it in millivolts?"),
        ("supply_voltage_v", 0.048, "is it in kilovolts?"),
        ("current_limit_a", 26e3, "is it in milliampere, or is rated_power_w in kilowatts?"),
        ("current_limit_a", 0.026, "is it in kiloampere?"),
        ("hysteresis_band_a", 250.0, "is it in milliampere?"),
        ("base_speed_rpm", 0.5, "is it in thousands of turns a minute?"),
        ("friction_n_m", 100.0, "is it in millinewton metres?"),
        ("core_loss_conductance_s", 3.0, "is it in millisiemens?"),
    ],
)
def test_a_wrong_unit_is_reported_with_value_range_and_unit(key, value, asked):
    (sentence,) = unusual_values(changed(**{key: value}))
    assert sentence.startswith(f"the drive's {key} is {value:g}, but usual for "), sentence
    assert "; it is expected in " in sentence
    assert sentence.endswith(asked), sentence


@pytest.mark.parametrize(
    ("key", "value", "unit"),
    [
        ("resistance_ohm", 570.0, "milliohm"),
        ("direct_inductance_h", 8.72, "millihenry"),
        ("quadrature_inductance_h", 22780.0, "microhenry"),
        # One flux of 0.0879 V s, as data sheets state it of 2 pole pairs.
        ("magnet_flux_v_s", 87.9, "millivolt seconds"),
        ("magnet_flux_v_s", 0.264, "newton metres per ampere"),
        ("magnet_flux_v_s", 22.5, "volts per 1000 turns a minute"),
        ("magnet_flux_v_s", 0.552, "volts per hertz"),
        ("magnet_flux_v_s", 31.4, "turns a minute per volt"),
        ("inertia_kg_m2", 20e3, "gram square centimetres"),
        ("link_voltage_v", 0.1225, "kilovolts"),
        ("rated_power_w", 0.5, "rated_power_w in kilowatts"),
        ("current_limit_a", 7070.0, "milliampere"),
    ],
)
def test_a_unit_of_data_sheets_is_asked_about_on_a_pm_ac_drive(key, value, unit):
    (sentence,) = unusual_values(changed(INTERIOR, **{key: value}))
    said = "current_limit_a is 7.07" if key == "rated_power_w" else f"{key} is {value:g}"
    assert sentence.startswith(f"the drive's {said}, but usual for "), sentence
    assert unit in sentence.partition("; it is expected in ")[2].partition(": ")[2], sentence


def test_the_sentence_reads_as_a_whole():
    assert unusual_values(changed(resistance_ohm=300.0)) == (
        "the drive's resistance_ohm is 300, but usual for 48 V and 26 A is 0.0018 to 5.5; it is expected in ohm: "
        "is it in milliohm?",
    )


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"resistance_ohm": 0.0, "hysteresis_band_a": 0.0},
        {"resistance_ohm": 0.04},
        {"resistance_ohm": 0.8, "inertia_kg_m2": 2.0, "friction_n_m": 5.0},
        # A servo for mains voltage, a small motor at high speed, and a large one for a ship.
        {
            "phases": 3,
            "pole_pairs": 4,
            "supply_voltage_v": 300.0,
            "current_limit_a": 10.0,
            "rated_power_w": 2000.0,
            "base_speed_rpm": 3000.0,
            "resistance_ohm": 1.0,
            "inductance_h": 5e-3,
            "emf_constant_v_s_per_rad": 0.5,
            "inertia_kg_m2": 1e-3,
        },
        {
            "phases": 3,
            "pole_pairs": 7,
            "supply_voltage_v": 6.0,
            "current_limit_a": 20.0,
            "rated_power_w": 200.0,
            "base_speed_rpm": 10000.0,
            "resistance_ohm": 0.05,
            "inductance_h": 2e-5,
            "emf_constant_v_s_per_rad": 5e-3,
            "inertia_kg_m2": 1e-5,
        },
        {
            "phases": 15,
            "pole_pairs": 6,
            "supply_voltage_v": 3000.0,
            "current_limit_a": 1200.0,
            "rated_power_w": 19e6,
            "base_speed_rpm": 150.0,
            "resistance_ohm": 0.03,
            "inductance_h": 5e-3,
            "emf_constant_v_s_per_rad": 150.0,
            "inertia_kg_m2": 1e5,
        },
    ],
    ids=["as it comes", "ideal", "half the resistance", "far off", "servo", "small", "ship"],
)
def test_drives_of_other_kinds_are_usual(values):
    assert unusual_values(changed(**values)) == ()
