"""Answers as the sheets of twenty makers print them, each with the drive that they make.

The numbers are of machines of that size, and the spellings those of the maker. What they make is stated as a
calculation on plain numbers, which knows nothing of units.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import pytest

from drivegate.studies.data_sheet_drive import QUESTIONS, data_sheet_drive

RMS, LINE = math.sqrt(2.0), math.sqrt(3.0)
RPM = 2.0 * math.pi / 60.0
OUNCE_INCH = 0.0070615518  # N·m
POUND_INCH = 0.1129848  # N·m


@dataclass(frozen=True)
class Sheet:
    """One machine: its answers in the order of the questions, and what they are in SI units."""

    maker: str
    answers: str
    """Poles | constant | resistance | inductance | inertia | rated and peak current | voltage | speeds | PWM."""
    pairs: int
    flux: float
    ohm: float
    henry: float
    inertia: float
    current: float
    """Rated current, peak value."""
    volt: float
    speed: float


SHEETS = (
    Sheet(
        "Maxon",
        "1 pair|25.5 mNm/A dc|0.447 Ω terminal, phase to phase|0.049 mH phase to phase|33.3 gcm²|4.36 A dc|40 A DC"
        "|24 V|6000 rpm|7000 rpm|50 kHz",
        1, 0.0255 / LINE, 0.2235, 24.5e-6, 33.3e-7, 4.36 * 2.0 / LINE, 24.0, 6000.0,
    ),
    Sheet(
        "Faulhaber",
        "2 pole pairs|11.4 mNm/A DC|1,1 Ω|120 µH|3.4 gcm²|1,8 A dc|6 A dc|24 V|8 000 min⁻¹|12000 min-1|40 kHz",
        2, 0.0114 / LINE / 2, 0.55, 60e-6, 3.4e-7, 1.8 * 2.0 / LINE, 24.0, 8000.0,
    ),
    Sheet(
        "Faulhaber, speed constant",
        "2 pole pairs|837 min⁻¹/V|1.1 Ω|120 µH|3.4 gcm²|1.8 A dc|6 A dc|24 V|8000 min⁻¹|12000 min⁻¹|40 kHz",
        2, 60.0 / (2.0 * math.pi * 837.0 * LINE * 2), 0.55, 60e-6, 3.4e-7, 1.8 * 2.0 / LINE, 24.0, 8000.0,
    ),
    Sheet(
        "Kollmorgen",
        "10 poles|49.5 Vrms/kRPM|2.1 Ohm L-L at 25°C|7.0 mH L-L|0.000058 lb-ft-s²|4.5 Arms|18.3 Arms|320 Vdc"
        "|4000 rpm|6000 rpm|10 kHz",
        5, 49.5 * RMS / (LINE * 1000.0 * RPM * 5), 1.05, 3.5e-3, 0.000058 * 12 * POUND_INCH, 4.5 * RMS, 320.0, 4000.0,
    ),
    Sheet(
        "Kollmorgen, inch",
        "10 poles|7.22 lb-in/Arms|2.1 Ω (l-l)|7.0 mH (l-l)|0.00056 lb-in-s²|4.5 A rms|18.3 A rms|230 V AC"
        "|4000 RPM|6000 RPM|10 kHz",
        5, 7.22 * POUND_INCH / (1.5 * RMS * 5), 1.05, 3.5e-3, 0.00056 * POUND_INCH, 4.5 * RMS, 230 * RMS, 4000.0,
    ),
    Sheet(
        "Yaskawa",
        "10 poles|0.498 N·m/Arms|0.6 Ω/phase|2.1 mH/phase|0.259×10⁻⁴ kg·m²|2.5 Arms|9.3 Arms|200 V AC"
        "|3000 min⁻¹|6000 min⁻¹|10.7 kHz",
        5, 0.498 / (1.5 * RMS * 5), 0.6, 2.1e-3, 0.259e-4, 2.5 * RMS, 200 * RMS, 3000.0,
    ),
    Sheet(
        "Estun",
        "4 pairs|30.9 V/krpm rms|4.6 ohm l-l|16.9 mH l-l|0.31 kg.m2 x10-4|2.7 A rms|8.1 A rms|300 V dc"
        "|3000 r/min|4500 r/min|10 kHz",
        4, 30.9 * RMS / (LINE * 1000.0 * RPM * 4), 2.3, 8.45e-3, 0.31e-4, 2.7 * RMS, 300.0, 3000.0,
    ),
    Sheet(
        "Siemens",
        "3 pairs|98 V/1000 min-1 rms|1.06 Ω per phase|9.2 mH per phase|6.5 10-4 kgm2"
        "|4.4 Aeff|19 Aeff|600 V DC|3000 1/min|3600 1/min|8 kHz",
        3, 98 * RMS / (LINE * 1000.0 * RPM * 3), 1.06, 9.2e-3, 6.5e-4, 4.4 * RMS, 600.0, 3000.0,
    ),
    Sheet(
        "T-Motor",
        "12N14P|KV380|62 mΩ|30 uH|706 g·cm²|15 A peak|25 A peak|24V|3500 RPM|8000 RPM|24 kHz",
        7, 1.0 / (380.0 * RPM * LINE * 7), 0.031, 15e-6, 706e-7, 15.0, 24.0, 3500.0,
    ),
    Sheet(
        "Nanotec",
        "8|3.5 oz-in/A dc|0.75 Ohm|2.1 mH|17 oz-in² x10-2|3.29 A dc|10.6 A dc|48 VDC|3500 rpm|4500 rpm|20 kHz",
        4, 3.5 * OUNCE_INCH / LINE / 4, 0.375, 1.05e-3, 0.17 * 1.829e-5, 3.29 * 2.0 / LINE, 48.0, 3500.0,
    ),
    Sheet(
        "Portescap",
        "4 poles|2.1 mV/rpm peak|0.9 ohms|0.11 mH|2.5 10^-7 kg·m²|2,7 A dc|9,5 A dc|24 V|7000 rpm|8000 rpm|60 kHz",
        2, 2.1e-3 / (RPM * LINE * 2), 0.45, 55e-6, 2.5e-7, 2.7 * 2.0 / LINE, 24.0, 7000.0,
    ),
    Sheet(
        "Parker",
        "8 poles|0.41 V/rad/s peak|2.58 ohms line-line|9.5 mH line-line|0.000041 kg-m^2|3.9 Apk|11.7 Apk|340 V"
        "|4000 rpm|5000 rpm|16 kHz",
        4, 0.41 / (LINE * 4), 1.29, 4.75e-3, 41e-6, 3.9, 340.0, 4000.0,
    ),
    Sheet(
        "Moog",
        "12 poles|0.93 Nm/Arms|1.9 Ohm (line to line, 25 °C)|7.3 mH (line to line)|3.1 kg cm²|5.9 Arms|22 Arms"
        "|565 VDC|3000 rpm|4200 rpm|8 kHz",
        6, 0.93 / (1.5 * RMS * 6), 0.95, 3.65e-3, 3.1e-4, 5.9 * RMS, 565.0, 3000.0,
    ),
    Sheet(
        "Allied Motion",
        "14 poles|16.2 oz-in/Apk|0.31 Ω terminal|0.4 mH terminal|0.0102 oz-in-sec²|9.2 A peak|30 A peak|48 Vdc"
        "|2900 rpm|3600 rpm|20 kHz",
        7, 16.2 * OUNCE_INCH / (1.5 * 7), 0.155, 0.2e-3, 0.0102 * OUNCE_INCH, 9.2, 48.0, 2900.0,
    ),
    Sheet(
        "Teknic",
        "8 poles|0.0399 V/Hz|0.72 ohm phase-phase|0.40 mH phase-phase|0.0000094 N·m·s²|7.1 A peak|21 A pk|75 V"
        "|5000 RPM|6000 RPM|20000 Hz",
        4, 0.0399 / (2.0 * math.pi), 0.36, 0.2e-3, 9.4e-6, 7.1, 75.0, 5000.0,
    ),
    Sheet(
        "Mitsubishi",
        "Number of poles: 10|18.5 mV/(r/min)/phase rms|0.45 Ω ±7 % phase|1.9 mH phase|0.234 ×10^-4 kg·m^2"
        "|2.6 A (rms)|9.1 A (rms)|1~ 230 V AC|3000 r/min|6000 r/min|9 kHz",
        5, 0.0185 * RMS / (RPM * 5), 0.45, 1.9e-3, 0.234e-4, 2.6 * RMS, 230 * RMS, 3000.0,
    ),
    Sheet(
        "Celera",
        "20 pole pairs|Ke = 0.173 V·s/rad peak|Terminal resistance: 0.73 Ω|0.57 mH @ 1 kHz|0,59 kg·cm²|6.3 Arms"
        "|20.8 Arms|48 V|2 100 rpm|2 500 rpm|20 kHz",
        20, 0.173 / (LINE * 20), 0.365, 0.285e-3, 0.59e-4, 6.3 * RMS, 48.0, 2100.0,
    ),
    Sheet(
        "Bosch Rexroth",
        "8-pole|76.3 Vrms/1000 min⁻¹|3.6 Ohm (20 °C)|23.9 mH|0.0012 kgm²|5.1 A(eff)|22.5 A(eff)|3 AC 400 V"
        "|3000 min⁻¹|4500 min⁻¹|4 kHz",
        4, 76.3 * RMS / (LINE * 1000.0 * RPM * 4), 1.8, 11.95e-3, 0.0012, 5.1 * RMS, 400 * RMS, 3000.0,
    ),
    Sheet(
        "Leadshine",
        "5 pairs of poles|5.1 kgf·cm/Arms|1.55 Ω (L-L)|5.6 mH (L-L)|0.66 Kg·cm²|4.2 Arms|12.6 Arms|220VAC"
        "|3000 r/min|5000 r/min|16kHz",
        5, 5.1 * 0.0980665 / (1.5 * RMS * 5), 0.775, 2.8e-3, 0.66e-4, 4.2 * RMS, 220 * RMS, 3000.0,
    ),
    Sheet(
        "an interior machine",
        "3 pairs|0.545 Wb|3.6 ohm phase|L_d/L_q = 36/51 mH phase|0.015 kg·m²|4.8 A eff|9.6 A eff|540 V dc"
        "|1500 U/min|1800 U/min|5 kHz",
        3, 0.545, 3.6, 36e-3, 0.015, 4.8 * RMS, 540.0, 1500.0,
    ),
)  # fmt: skip


@pytest.mark.parametrize("sheet", SHEETS, ids=lambda sheet: sheet.maker)
def test_a_sheet_makes_the_drive_of_its_numbers(sheet: Sheet) -> None:
    texts = sheet.answers.split("|")
    answers = {
        key: question.read(text) for (key, question), text in zip(QUESTIONS.items(), texts, strict=True)
    }
    drive = data_sheet_drive("machine", answers)
    machine = drive.machine
    assert machine.pole_pairs == sheet.pairs
    read = {
        "flux": machine.magnet_flux_v_s,
        "resistance": machine.resistance_ohm,
        "inductance": machine.direct_inductance_h,
        "inertia": machine.inertia_kg_m2,
        "current": drive.rating.continuous_current_a,
        "voltage": drive.inverter.link_voltage_v,
        "speed": drive.rating.base_speed_rpm,
    }
    stated = (sheet.flux, sheet.ohm, sheet.henry, sheet.inertia, sheet.current, sheet.volt, sheet.speed)
    assert read == pytest.approx(dict(zip(read, stated, strict=True)), rel=1e-4)


def test_the_currents_of_a_sheet_produce_its_torque() -> None:
    """With Kt of a dc current, the dc current that becomes 1.155 times as much at its peak gives Kt times itself."""
    sheet = next(sheet for sheet in SHEETS if sheet.maker == "Nanotec")
    texts = sheet.answers.split("|")
    answers = {
        key: question.read(text) for (key, question), text in zip(QUESTIONS.items(), texts, strict=True)
    }
    drive = data_sheet_drive("machine", answers)
    assert drive.torque_of_current(sheet.current) == pytest.approx(3.5 * OUNCE_INCH * 3.29, rel=1e-4)
