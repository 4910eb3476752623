"""Single answers as the sheets of makers print them: what each means, and what is asked for where it is open.

The values are plain calculations, which know nothing of units.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import pytest

from drivegate.studies.data_sheet_drive import QUESTIONS
from drivegate_models.errors import InputError

RMS, LINE = math.sqrt(2.0), math.sqrt(3.0)
RPM = 2.0 * math.pi / 60.0
OUNCE_INCH = 0.0070615518  # N·m
POUND_INCH = 0.1129848  # N·m
KILOGRAM_CM = 0.0980665  # N·m
OUNCE_INCH_2 = 1.8289978e-5  # kg·m²
POUND_INCH_2 = 2.9263965e-4  # kg·m²
DC = 2.0 / LINE
"""Peak current over the direct current of the same torque."""


def torque(constant: float, per: str) -> float:
    """Flux linkage times pole pairs (V·s) from a torque constant (N·m/A)."""
    return constant / {"rms": 1.5 * RMS, "peak": 1.5, "dc": LINE}[per]


def emf(volt_seconds: float, kind: str = "peak", *, of_phase: bool = False) -> float:
    """Flux linkage times pole pairs (V·s) from an EMF constant (V·s/rad)."""
    return volt_seconds * (RMS if kind == "rms" else 1.0) / (1.0 if of_phase else LINE)


def speed(rpm_per_volt: float) -> float:
    return 1.0 / (rpm_per_volt * RPM * LINE)


ANSWERS: dict[str, dict[str, tuple[tuple[str, float], ...]]] = {
    "maxon": {
        "poles": (("Number of pole pairs 1", 1), ("Number of pole pairs: 11", 11), ("8 (number of pole pairs)", 8)),
        "constant": (
            ("14.2 mNm/A (dc)", torque(0.0142, "dc")), ("672 rpm/V", speed(672)), ("672 min⁻¹ V⁻¹", speed(672)),
            ("Speed constant [rpm/V] 672", speed(672)), ("45,8 mNm/A dc ±10 %", torque(0.0458, "dc")),
        ),
        "resistance": (
            ("Terminal resistance phase to phase [Ω] 0.447", 0.2235), ("0.447 Ω (25 °C) ± 10%", 0.2235),
        ),
        "inductance": (("Terminal inductance phase to phase [mH]: 0.049", 24.5e-6),),
        "inertia": (("Rotor inertia [gcm²] 33.3", 33.3e-7), ("3'060 gcm2", 3.06e-4)),
        "rated_current": (("Nominal current (max. continuous current) 4.36 A dc", 4.36 * DC),),
        "highest_speed": (("12'000 rpm", 12000.0), ("max. 12000 rpm", 12000.0)),
    },
    "Faulhaber": {
        "poles": (("2 pole pairs", 2),),
        "constant": (
            ("837 min⁻¹/V", speed(837)), ("1,195 mV/min⁻¹ peak", None), ("11,4 mNm/A dc", torque(0.0114, "dc")),
        ),
        "resistance": (("Terminal resistance, phase-phase: 1,1 Ω ±12%", 0.55),),
        "rated_speed": (("8 000 min⁻¹", 8000.0), ("8\u202f000 min-1", 8000.0), ("3000 min−1", 3000.0)),
    },
    "Kollmorgen": {
        "constant": (
            ("1.04 Nm/Arms ±10 %", torque(1.04, "rms")), ("7.22 lb-in/Arms", torque(7.22 * POUND_INCH, "rms")),
            ("49.5 Vrms/kRPM", emf(0.0495 / RPM, "rms")), ("9.2 in-lb/A rms", torque(9.2 * POUND_INCH, "rms")),
        ),
        "resistance": (("2.1 Ohm L-L @ 25 °C", 1.05), ("2.1 Ω line-to-line ±10%", 1.05), ("2.1 ohms (l-l)", 1.05)),
        "inductance": (("7.0 mH L-L @ 1 kHz", 3.5e-3), ("7.0 mH line to line, 1 kHz", 3.5e-3)),
        "inertia": (("0.00056 lb-in-s²", 0.00056 * POUND_INCH), ("0.000047 lb-ft-sec^2", 0.000047 * 12 * POUND_INCH)),
        "rated_current": (("4.5 Arms continuous stall", 4.5 * RMS), ("4.5 A[rms]", 4.5 * RMS)),
        "peak_current": (("18.3 Arms (3 s)", 18.3 * RMS), ("18.3 A rms for 2 s", 18.3 * RMS)),
        "voltage": (("320 Vdc bus", 320.0), ("480 VAC", 480.0 * RMS), ("230 VAC 50/60 Hz", 230.0 * RMS)),
        "frequency": (("16,5 kHz", 16.5e3), ("8 kHz PWM", 8e3)),
    },
    "T-Motor": {
        "poles": (("24N28P", 14), ("36N42P", 21), ("14P", 7), ("12S14P", 7), ("24N/28P", 14)),
        "constant": (
            ("KV380", speed(380)), ("380 KV", speed(380)), ("KV: 380", speed(380)), ("380 rpm/V ± 5%", speed(380)),
        ),
        "resistance": (("62 mΩ", 0.031), ("52±2 mΩ", 0.026), ("0.36 (1±10%) Ω", 0.18), ("62 m Ω", 0.031)),
        "peak_current": (("25 A peak (180 s)", 25.0), ("25 Apeak, 10 s", 25.0)),
        "voltage": (("22.2 V (6S)", 22.2), ("48V 12S LiPo", 48.0)),
        "rated_speed": (("1000rpm", 1000.0), ("11000", 11000.0), ("21000 rpm", 21000.0)),
    },
    "Moog": {
        "constant": (("0.93 Nm/Arms", torque(0.93, "rms")), ("20.7 oz-in/Apk", torque(20.7 * OUNCE_INCH, "peak"))),
        "resistance": (("1.9 Ohm (line to line, 25 °C)", 0.95), ("1.9 ohms ±12.5 % @ 25°C", 0.95)),
        "inertia": (
            ("3.1 kg cm²", 3.1e-4), ("0.0047 oz-in-s²", 0.0047 * OUNCE_INCH),
            ("0.0047 oz.in.sec²", 0.0047 * OUNCE_INCH),
        ),
    },
    "Allied Motion": {
        "poles": (("No. of poles 8", 4), ("14-pole", 7)),
        "constant": (
            ("16.2 oz-in/A peak", torque(16.2 * OUNCE_INCH, "peak")),
            ("13.4 in-oz/Arms", torque(13.4 * OUNCE_INCH, "rms")),
        ),
        "resistance": (("0.31 Ω terminal, cold", 0.155), ("0.31 ohms nom.", 0.155), ("R25 = 0.31 ohm", 0.155)),
        "inertia": (("0.0102 oz-in-sec²", 0.0102 * OUNCE_INCH), ("1.8 oz-in²", 1.8 * OUNCE_INCH_2)),
        "rated_current": (("9.2 A peak of sine", 9.2), ("9.2 amps (peak)", 9.2), ("9.2 A 0-pk", 9.2)),
    },
    "Nanotec": {
        "constant": (("3.5 oz-in/A dc", torque(3.5 * OUNCE_INCH, "dc")), ("4,13 Ncm/A dc", torque(0.0413, "dc"))),
        "inductance": (("2.1 mH @ 1 kHz, 1 V", 1.05e-3), ("2,1 mH", 1.05e-3)),
        "inertia": (("119 g·cm²", 119e-7), ("33.3 gm-cm²", 33.3e-7)),
        "voltage": (("48 VDC", 48.0), ("DC 48 V", 48.0), ("48 V⎓", 48.0), ("48 V =", 48.0), ("36 V battery", 36.0)),
    },
    "Oriental": {
        "constant": (("0.062 N·m/A (0-peak)", torque(0.062, "peak")),),
        "inertia": (("J: 0.61×10⁻⁴ kg·m²", 0.61e-4), ("0.61 ×10^-4 kg·m^2 (w/o brake)", 0.61e-4)),
        "rated_speed": (("3000 r/min", 3000.0), ("3000 (r/min)", 3000.0), ("80~4000 r/min", None)),
        "voltage": (("Single-Phase 230 VAC", 230.0 * RMS), ("three-phase 200 VAC", 200.0 * RMS)),
    },
    "Yaskawa": {
        "constant": (("0.498 N·m/Arms", torque(0.498, "rms")), ("0.498 N·m/A(rms)", torque(0.498, "rms"))),
        "resistance": (("0.6 Ω/phase", 0.6), ("Rph = 0.6 Ω", 0.6)),
        "inductance": (("2.1 mH/phase", 2.1e-3), ("Lph: 2.1 mH", 2.1e-3)),
        "inertia": (
            ("Rotor inertia (×10⁻⁴ kg·m²) 0.259", 0.259e-4), ("0.259 [×10⁻⁴ kg·m²]", 0.259e-4),
            ("0.259 E-4 kgm²", 0.259e-4),
        ),
        "rated_speed": (
            ("3000 min⁻¹", 3000.0), ("3000 min^-1", 3000.0), ("3000 min^{-1}", 3000.0), ("3000 min**-1", 3000.0),
        ),
    },
    "Estun": {
        "poles": (("4 pairs", 4), ("pole pairs (p): 5", 5), ("2p = 10", 5)),
        "constant": (("30.9 V/krpm rms", emf(0.0309 / RPM, "rms")), ("30.9 mV/(r/min) rms", emf(0.0309 / RPM, "rms"))),
        "inertia": (("0.31 kg.m2 x10-4", 0.31e-4), ("0.31 kgm² E-4", 0.31e-4), ("0.31 kg*m^2*1e-4", 0.31e-4)),
        "rated_current": (("2.7 A rms/phase", 2.7 * RMS), ("2.7 A_rms", 2.7 * RMS)),
    },
    "Teknic": {
        "constant": (
            ("0.0399 V/Hz (peak, phase)", 0.0399 / (2 * math.pi)), ("0.0399 Vpeak/Hz", 0.0399 / (2 * math.pi)),
            ("20.4 Vpk L-L / kRPM", emf(0.0204 / RPM)), ("20.4 V peak/krpm", emf(0.0204 / RPM)),
        ),
        "resistance": (
            ("0.72 ohm phase-phase", 0.36), ("0.72 Ω ph/ph", 0.36), ("0.72 Ω p-p", 0.36), ("0.72 ohm/ph-ph", 0.36),
        ),
        "inertia": (("0.0013 oz-in-s2", 0.0013 * OUNCE_INCH), ("9.4e-6 N·m·s²", 9.4e-6)),
    },
    "ebm-papst": {
        "poles": (("8-polig", 4), ("Polpaarzahl 4", 4), ("Polzahl 8", 4), ("4 Polpaare", 4)),
        "constant": (("KT 0,095 Nm/A Spitze", None), ("5,2 V/1000 min-1 eff", emf(0.0052 / RPM, "rms"))),
        "rated_speed": (("3 000 1/min", 3000.0), ("3000 U/min", 3000.0), ("3000 Upm", 3000.0)),
        "rated_current": (("2,8 A eff.", 2.8 * RMS), ("2,8 Aeff", 2.8 * RMS)),
    },
    "Bafang": {
        "poles": (("20 pole pairs (40 poles)", 20), ("40 magnets", 20), ("8 poles / 4 pole pairs", 4)),
        "constant": (("9.2 rpm/V (no load)", speed(9.2)),),
        "resistance": (("120 milliohm", 0.06), ("120 mOhms", 0.06), ("120 milli-ohm", 0.06)),
        "rated_speed": (("275 rpm no-load", 275.0), ("275 rpm @ 48 V", 275.0)),
    },
    "Siemens": {
        "constant": (("98 V/1000 min-1 rms", emf(0.098 / RPM, "rms")), ("98 V/1,000 rpm rms", emf(0.098 / RPM, "rms"))),
        "resistance": (("1,06 Ω per phase", 1.06), ("1.06 Ω (phase, 20 °C)", 1.06)),
        "voltage": (("3 AC 400 V", 400.0 * RMS), ("600 V DC link", 600.0), ("3~ 400 V", 400.0 * RMS)),
    },
    "Parker": {
        "constant": (
            ("0.41 V/rad/s peak", emf(0.41)), ("0.41 V/(rad/s) pk", emf(0.41)), ("0.41 V.s/rad peak", emf(0.41)),
        ),
        "rated_speed": (("314.159265 rad/s", 3000.0), ("18000 deg/s", 3000.0), ("50 rev/s", 3000.0)),
    },
    "Mitsubishi": {
        "poles": (("Number of poles: 10", 5),),
        "constant": (("18.5 mV/(r/min)/phase rms", emf(0.0185 / RPM, "rms", of_phase=True)),),
        "rated_current": (("Rated current (Arms): 2.6", 2.6 * RMS), ("2.6 Arms @ 40 °C ambient", 2.6 * RMS)),
    },
    "Bosch Rexroth": {
        "constant": (("76.3 Vrms/1000 min⁻¹", emf(0.0763 / RPM, "rms")), ("1.28 Nm/A_RMS", torque(1.28, "rms"))),
        "highest_speed": (("6 000 min⁻¹", 6000.0), ("6000 rpm (mech.)", 6000.0), ("6 k rpm mechanical limit", 6000.0)),
    },
    "Leadshine": {
        "constant": (
            ("5.1 kgf·cm/Arms", torque(5.1 * KILOGRAM_CM, "rms")),
            ("5.1 kg-cm/A rms", torque(5.1 * KILOGRAM_CM, "rms")),
        ),
        "inertia": (("0.66 Kg·cm²", 0.66e-4), ("5.4 kgf.cm.s2", 5.4 * KILOGRAM_CM), ("0.66 kg•cm²", 0.66e-4)),
        "voltage": (("220VAC", 220.0 * RMS), ("AC220V", 220.0 * RMS), ("230 V~", 230.0 * RMS)),
    },
    "Portescap": {
        "constant": (("2.1 mV/rpm peak", emf(0.0021 / RPM)), ("2.1 mV/min-1 (peak, line-line)", emf(0.0021 / RPM))),
        "inertia": (("2.5 10^-7 kg·m²", 2.5e-7), ("2.5·10⁻⁷ kg·m²", 2.5e-7), ("2.5 kg·m² (10⁻⁷)", 2.5e-7)),
    },
    "Delta": {
        "constant": (("0.51 N-m/A rms", torque(0.51, "rms")), ("16 mV/(min-1) rms", emf(0.016 / RPM, "rms"))),
        "inertia": (
            ("0.277 ×10⁻⁴ kg.m²", 0.277e-4), ("0.277 x 10^-4 kg-m2", 0.277e-4), ("0.277 (10⁻⁴ kg·m²)", 0.277e-4),
            ("0.277 (kg·m²×10⁻⁴)", 0.277e-4),
        ),
    },
    "Panasonic": {
        "inertia": (("0.14 ×10⁻⁴ kg·m² (without brake)", 0.14e-4),),
        "rated_current": (("1.5 A (rms)", 1.5 * RMS), ("1.5 A(r.m.s.)", 1.5 * RMS)),
        "peak_current": (("6.5 A (0-p)", 6.5), ("6.5 Ap", 6.5), ("6.5 A o-p", 6.5), ("6.5 A zero-to-peak", 6.5)),
    },
    "Beckhoff": {
        "constant": (("1.87 Nm/A rms", torque(1.87, "rms")), ("1,87 Nm/Aeff", torque(1.87, "rms"))),
        "inductance": (("Ld = 0.5 mH, Lq = 0.8 mH (phase)", 0.5e-3), ("Lq 0.8 mH, Ld 0.5 mH phase", 0.5e-3)),
    },
    "TQ-Robodrive": {
        "constant": (
            ("0.13 Nm/A peak", torque(0.13, "peak")), ("0.075 Vs/rad rms phase", emf(0.075, "rms", of_phase=True)),
        ),
        "resistance": (("Phase resistance 62 mΩ", 0.062), ("62 mΩ/ph", 0.062), ("62 mΩ L-N", 0.062)),
        "inductance": (
            ("Ld = Lq = 60 µH phase", 60e-6), ("60 μH per phase", 60e-6), ("0.5 mH (Ld), 0.8 mH (Lq) phase", 0.5e-3),
        ),
    },
    "Celera": {
        "constant": (
            ("0.173 V·s/rad peak", emf(0.173)), ("0.173 V-s/rad pk", emf(0.173)), ("173 mVs/rad peak", emf(0.173)),
        ),
        "resistance": (("0.73 Ω @ 25 deg C", 0.365), ("0.73 Ω, ±10 %", 0.365), ("0.73 Ω ±0.05 Ω", 0.365)),
        "inductance": (
            ("570 uH @ 1kHz", 0.285e-3), ("570 µH (1 kHz)", 0.285e-3), ("0.8 mH (Lq) / 0.5 mH (Ld) phase", 0.5e-3),
        ),
    },
    "traction": {
        "constant": (("0.545 Wb", 0.545), ("54.5 mWb", 0.0545), ("flux linkage 0.0157 V·s", 0.0157)),
        "rated_speed": (
            ("3,5 krpm", 3500.0), ("12.5 kRPM", 12500.0), ("10,500.0 rpm", 10500.0), ("10.500,0 min-1", 10500.0),
        ),
        "voltage": (("0.6 kV", 600.0), ("565 Vdc nom.", 565.0), ("230 V 1~", 230.0 * RMS)),
        "frequency": (("20 kHz", 20e3), ("20 000 Hz", 20e3), ("12.5kHz (center-aligned)", 12.5e3)),
    },
}  # fmt: skip
"""Answers by maker and question, with their value; none where the answer is open and asked for again."""


def rows() -> Iterator[tuple[str, str, float | None]]:
    for questions in ANSWERS.values():
        for key, answers in questions.items():
            for text, value in answers:
                yield key, text, value


def test_there_are_enough_of_them() -> None:
    assert len(ANSWERS) >= 25
    assert sum(value is not None for _, _, value in rows()) >= 150
    assert {key for key, _, _ in rows()} == set(QUESTIONS)


@pytest.mark.parametrize(("key", "text", "value"), list(rows()))
def test_an_answer_of_a_sheet_is_read_or_asked_for_again(key: str, text: str, value: float | None) -> None:
    if value is None:
        with pytest.raises(InputError):
            QUESTIONS[key].read(text)
    else:
        assert QUESTIONS[key].read(text).value == pytest.approx(value, rel=1e-4)


@pytest.mark.parametrize(
    ("key", "text", "words"),
    [
        ("rated_speed", "4.600 rpm", "may mean 4.6 or 4600"),
        ("rated_speed", "4,600 rpm", "may mean 4.6 or 4600"),
        ("highest_speed", "10.500 min-1", "may mean 10.5 or 10500"),
        ("constant", "1.100 KV", "may mean 1.1 or 1100"),
        ("inertia", "1,200 g·cm²", "may mean 1.2 or 1200"),
        ("frequency", "20.000 Hz", "may mean 20 or 20000"),
        ("resistance", "Rs = 0.18 Ω", "add 'phase' or 'line-line'"),
        ("inductance", "Ls = 0.06 mH", "add 'phase' or 'line-line'"),
        ("inductance", "Ld = 0.5 mH", "add 'phase' or 'line-line'"),
        ("rated_current", "2.8 A ac", "'rms' or 'peak'"),
        ("rated_current", "2.8 A DC bus", "accepted: A or mA"),
        ("rated_current", "0.4 A rms no load", "accepted: A or mA"),
        ("constant", "0.2 Vs/rad", "add 'rms', 'peak'"),
        ("constant", "1.17 Nm", "accepted: N·m/A"),
        ("constant", "30 Vpp/krpm", "accepted: N·m/A"),
        ("resistance", "0.32–0.40 Ω", "accepted: ohm"),
        ("voltage", "24...48 V", "accepted: V"),
        ("rated_speed", "3000 erpm", "accepted: rpm"),
        ("rated_speed", "50 s-1", "accepted: rpm"),
        ("poles", "p = 4", "accepted: 8, 8 poles"),
        ("poles", "8/4", "states 4 and 8 poles"),
        ("poles", "12 slots", "accepted: 8, 8 poles"),
        ("poles", "8.5", "accepted: 8, 8 poles"),
    ],
)
def test_what_a_sheet_leaves_open_is_asked_for(key: str, text: str, words: str) -> None:
    with pytest.raises(InputError) as refused:
        QUESTIONS[key].read(text)
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)
