"""What a data sheet states becomes a drive: each unit is converted, and what is open is asked for."""

from __future__ import annotations

import math

import pytest

from drivegate.studies.data_sheet_drive import QUESTIONS, data_sheet_drive
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_models.errors import InputError

SERVO = {
    "poles": "8 poles",
    "constant": "0.5 N·m/A rms",
    "resistance": "1.2 ohm",
    "inductance": "4.4 mH",
    "inertia": "0.6 kg·cm²",
    "rated_current": "2.8 A rms",
    "peak_current": "8 A rms",
    "voltage": "300 V",
    "rated_speed": "3000 rpm",
    "highest_speed": "4000 rpm",
    "frequency": "16 kHz",
}
"""A servo motor of 400 W."""


def made(**answers: str) -> DriveDocument:
    texts = SERVO | answers
    return data_sheet_drive("servo", {key: question.read(texts[key]) for key, question in QUESTIONS.items()})


def test_a_data_sheet_makes_a_drive_that_states_each_conversion() -> None:
    drive = made()
    assert drive.machine.pole_pairs == 4
    assert drive.machine.resistance_ohm == 0.6
    assert drive.machine.direct_inductance_h == drive.machine.quadrature_inductance_h == 2.2e-3
    assert drive.machine.inertia_kg_m2 == pytest.approx(6e-5)
    assert drive.inverter.carrier_frequency_hz == 16e3
    assert drive.rating.peak_current_a == pytest.approx(8.0 * math.sqrt(2.0), rel=1e-4)
    assert 300.0 < drive.rating.rated_power_w < 500.0
    assert (
        drive.provenance["machine"]["resistance_ohm"]
        == "data sheet: 1.2 ohm; half of the value between two terminals"
    )
    stated = {f"{table}.{key}" for table, keys in drive.provenance.items() for key in keys}
    assert {f"machine.{key}" for key in ("magnet_flux_v_s", "pole_pairs", "inertia_kg_m2")} < stated


def test_torque_per_ampere_is_that_of_the_data_sheet() -> None:
    drive = made(constant="0.5 N·m/A rms")
    torque = drive.torque_of_current(math.sqrt(2.0))
    assert torque == pytest.approx(0.5, rel=1e-4)


def test_the_emf_is_that_of_the_data_sheet() -> None:
    """At 1000 rpm the line-to-line EMF is the stated one, from the flux linkage of a phase."""
    drive = made(constant="30 V/krpm rms")
    electrical = 4 * 2.0 * math.pi * 1000.0 / 60.0
    line = math.sqrt(3.0) * electrical * drive.machine.magnet_flux_v_s
    assert line / math.sqrt(2.0) == pytest.approx(30.0, rel=1e-4)


@pytest.mark.parametrize(
    "constant",
    [
        # One machine: 0.05 V s with 4 pole pairs.
        "50 mV·s",
        "0.05 Vs",
        "50 mWb",
        "0.3 N·m/A peak",
        "0.42426 Nm/A rms",
        "0.34641 Nm/A dc",
        "36.276 V/krpm peak",
        "25.651 Vrms/krpm",
        "25.651 V/1000 rpm rms",
        "27.566 rpm/V",
        "27.566 Kv",
    ],
)
def test_each_unit_of_the_constant_gives_the_same_flux(constant: str) -> None:
    assert made(constant=constant).machine.magnet_flux_v_s == pytest.approx(0.05, rel=1e-4)


@pytest.mark.parametrize(
    ("key", "text", "value"),
    [
        ("resistance", "600 mΩ phase", 0.6),
        ("resistance", "1.2Ω", 0.6),
        ("inductance", "4400 µH", 2.2e-3),
        ("inductance", "4400 μH", 2.2e-3),
        ("inertia", "600 g·cm^2", 6e-5),
        ("inertia", "6e-5 kg m2", 6e-5),
        ("voltage", "230 V ac", 325.27),
        ("poles", "4 pairs", 4),
        ("poles", "8", 4),
        ("rated_current", "4 A pk", 4.0),
    ],
)
def test_spellings_of_units(key: str, text: str, value: float) -> None:
    assert QUESTIONS[key].read(text).value == pytest.approx(value, rel=1e-4)


def test_two_inductances_are_of_one_phase() -> None:
    drive = made(inductance="8.72/22.78 mH phase")
    assert (drive.machine.direct_inductance_h, drive.machine.quadrature_inductance_h) == (8.72e-3, 22.78e-3)


@pytest.mark.parametrize(
    ("key", "text", "words"),
    [
        ("rated_current", "5 A", "say whether it is 'rms' or 'peak'"),
        ("constant", "0.5 N·m/A", "add 'rms', 'peak' or, for Kt of a dc current, 'dc'"),
        ("constant", "12 V/krpm", "add 'rms', 'peak'"),
        ("resistance", "0,42 ohm", "such as '0.42 ohm'"),
        ("resistance", "-1 ohm", "is not understood"),
        ("resistance", "0 ohm", "must be above 0"),
        ("resistance", "1e999 ohm", "must be above 0 and finite"),
        ("resistance", "", "is not understood"),
        ("resistance", "1/2 ohm", "is not understood"),
        ("inertia", "5 kg", "'120 g·cm²'"),
        ("poles", "7", "'7' makes no whole number of pole pairs"),
    ],
)
def test_what_is_open_or_wrong_is_refused_with_what_would_be_right(key: str, text: str, words: str) -> None:
    with pytest.raises(InputError) as refused:
        QUESTIONS[key].read(text)
    message = str(refused.value)
    assert message.startswith(f"{QUESTIONS[key].quantity}: ")
    assert words in message
