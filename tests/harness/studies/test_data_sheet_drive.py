"""What a data sheet states becomes a drive: each unit is converted, and what is open is asked for."""

from __future__ import annotations

import math

import pytest

from drivegate.studies.data_sheet_drive import QUESTIONS, data_sheet_drive
from drivegate_cases.documents.wording import LONGEST_MESSAGE
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
        ("rated_current", "3.29 A dc", 3.29 * 2.0 / math.sqrt(3.0)),
        ("resistance", "0,42 ohm", 0.21),
        ("poles", "1 pair", 1),
        ("poles", "14P", 7),
        ("poles", "12N14P", 7),
        ("rated_speed", "1000 rpm", 1000.0),
        ("rated_speed", "11000", 11000.0),
        ("rated_speed", "21000rpm", 21000.0),
        ("rated_speed", "3000 min-1", 3000.0),
        ("rated_speed", "314.159265 rad/s", 3000.0),
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
        ("resistance", "1,155 ohm", "may mean 1.155 or 1155"),
        ("rated_speed", "4.600 rpm", "may mean 4.6 or 4600; write it without a separator of thousands"),
        ("rated_current", "5 A", "'dc' (I_peak = 1.155 I_dc)"),
        ("rated_current", "5 App", "accepted: A or mA with rms, peak or dc"),
        ("constant", "40.4 mNm/A", "accepted: N·m/A, mN·m/A, oz-in/A, lb-in/A with rms, peak or dc"),
        ("inductance", "0.5/0.8 mH", "of L_d/L_q, add 'phase' or 'line-line'"),
        ("inductance", "4.4 MH", "a capital M is mega"),
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


def test_every_refusal_lists_what_is_accepted_on_one_short_line() -> None:
    for question in QUESTIONS.values():
        with pytest.raises(InputError) as refused:
            question.read("7 furlongs " + "x" * 500)
        message = str(refused.value)
        assert message.endswith(f"accepted: {question.accepted}")
        assert len(message) <= LONGEST_MESSAGE
        assert "\n" not in message


def test_each_value_of_a_pair_goes_to_its_axis() -> None:
    for text in (
        "8.72/22.78 mH phase",
        "Ld = 8.72 mH, Lq = 22.78 mH per phase",
        "Lq/Ld: 22.78/8.72 mH phase",
    ):
        drive = made(inductance=text)
        assert (drive.machine.direct_inductance_h, drive.machine.quadrature_inductance_h) == (
            8.72e-3,
            22.78e-3,
        )
