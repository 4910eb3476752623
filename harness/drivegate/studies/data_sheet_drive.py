"""A PM AC drive from what a data sheet states: each answer is converted, and the drive says how."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite, sqrt
from types import MappingProxyType
from typing import Any, Final

from drivegate_cases.documents.document import parse_document
from drivegate_cases.documents.wording import one_line
from drivegate_cases.drive.drive_document import PM_AC, DriveDocument
from drivegate_cases.drive.pm_ac.usual_values import FLUX_CONSTANTS
from drivegate_models.errors import InputError

_NUMBER: Final = re.compile(r"(?P<number>\d+\.?\d*(e[+-]?\d+)?|\.\d+)(/(?P<second>\d+\.?\d*))?(?P<unit>.*)")
_SPELLINGS: Final = (
    ("ω", "ohm"),
    ("ohms", "ohm"),
    ("²", "2"),
    ("μ", "u"),
    ("µ", "u"),
    ("1000rpm", "krpm"),
    ("pk", "peak"),
)
_IGNORED: Final = re.compile(r"[\s·*^]")
_DIGITS: Final = 5
"""Digits of a converted value: more than any data sheet states."""
_OVERSPEED: Final = 1.1
"""Highest speed of all over the highest speed of the data sheet (1)."""


@dataclass(frozen=True)
class Amount:
    """One answer as it was read."""

    value: float
    """Number times the size of its unit."""
    unit: str
    """The unit, in small letters and without spaces."""
    text: str
    second: float | None = None
    """Second number of a pair, times the size of the unit."""


@dataclass(frozen=True)
class Question:
    """One line of a data sheet."""

    quantity: str
    """What is asked for."""
    examples: str
    """Answers that would do."""
    units: Mapping[str, float]
    """Size of each unit, by its name in small letters and without spaces."""
    missing: str = ""
    """What is to be added to an answer whose unit leaves something open."""
    default: str = ""
    """The answer where none is given; empty for a question that requires one."""
    is_pair: bool = False
    """Whether two numbers may be stated, such as L_d/L_q."""
    is_whole: bool = False
    """Whether the value must be a whole number: of pole pairs."""

    def read(self, text: str) -> Amount:
        """Read an answer.

        Raises InputError if it is no number above 0 with one of the units, or makes no whole number of pole pairs.
        """
        plain = _IGNORED.sub("", text.lower())
        for spelling, unit in _SPELLINGS:
            plain = plain.replace(spelling, unit)
        found = _NUMBER.fullmatch(plain)
        unit = "" if found is None else found["unit"]
        if found is None or unit not in self.units or (found["second"] and not self.is_pair):
            open_unit = self.missing if any(known.startswith(unit) for known in self.units if unit) else ""
            raise InputError(
                f"{self.quantity}: '{one_line(text)[:60]}' is not understood; write a number with its unit, such as "
                f"{self.examples}{open_unit}"
            )
        size = self.units[unit]
        values = [float(number) * size for number in (found["number"], found["second"]) if number]
        if not all(isfinite(value) and value > 0.0 for value in values):
            raise InputError(f"{self.quantity}: '{one_line(text)[:60]}' must be above 0 and finite")
        if self.is_whole and values[0] != round(values[0]):
            raise InputError(f"{self.quantity}: '{one_line(text)[:60]}' makes no whole number of pole pairs")
        return Amount(values[0], unit, one_line(text).strip(), values[1] if found["second"] else None)


_OHM: Final = {"ohm": 1.0, "mohm": 1e-3}
_HENRY: Final = {"h": 1.0, "mh": 1e-3, "uh": 1e-6}
_AMPERE: Final = MappingProxyType({"arms": sqrt(2.0), "apeak": 1.0, "rmsa": sqrt(2.0), "peaka": 1.0})
_RMS_OR_PEAK: Final = "; say whether it is 'rms' or 'peak'"


def _with_phase(units: Mapping[str, float]) -> Mapping[str, float]:
    """Return units of the half of a value between two terminals, and of one phase."""
    return {name: 0.5 * size for name, size in units.items()} | {
        f"{name}phase": size for name, size in units.items()
    }


QUESTIONS: Final[Mapping[str, Question]] = MappingProxyType(
    {
        "poles": Question(
            "number of poles",
            "'8 poles' or '4 pairs'",
            {"": 0.5, "poles": 0.5, "pairs": 1.0, "polepairs": 1.0},
            is_whole=True,
        ),
        "constant": Question(
            "Kv, Kt or Ke",
            "'84 rpm/V', '0.12 N·m/A rms', '12 V/krpm rms' or '5.6 mV·s'",
            dict.fromkeys(FLUX_CONSTANTS, 1.0),
            missing=": add 'rms', 'peak' or, for Kt of a dc current, 'dc'",
        ),
        "resistance": Question(
            "resistance between two terminals",
            "'0.42 ohm', '420 mohm' or, of one phase, '0.21 ohm phase'",
            _with_phase(_OHM),
        ),
        "inductance": Question(
            "inductance between two terminals",
            "'1.2 mH', of one phase '0.6 mH phase', or L_d/L_q of one phase '0.5/0.8 mH phase'",
            _with_phase(_HENRY),
            is_pair=True,
        ),
        "inertia": Question(
            "inertia of rotor and load",
            "'120 g·cm²', '0.3 kg·cm²' or '3e-5 kg·m²'",
            {"kgm2": 1.0, "gm2": 1e-3, "kgcm2": 1e-4, "gcm2": 1e-7},
        ),
        "rated_current": Question("rated current", "'5 A rms' or '7.1 A peak'", _AMPERE, _RMS_OR_PEAK),
        "peak_current": Question("maximum current", "'15 A rms' or '21 A peak'", _AMPERE, _RMS_OR_PEAK),
        "voltage": Question(
            "supply voltage",
            "'48 V', or '230 V ac' for a rectified supply",
            {"v": 1.0, "vdc": 1.0, "vac": sqrt(2.0)},
        ),
        "rated_speed": Question("rated speed", "'3000 rpm'", {"": 1.0, "rpm": 1.0}),
        "highest_speed": Question("maximum speed", "'4500 rpm'", {"": 1.0, "rpm": 1.0}),
        "frequency": Question(
            "PWM frequency of your inverter", "'20 kHz'", {"hz": 1.0, "khz": 1e3}, default="20 kHz"
        ),
    }
)
"""What is asked for, in the order of data sheets."""


def data_sheet_drive(name: str, answers: Mapping[str, Amount]) -> DriveDocument:
    """Make a PM AC drive from a data sheet.

    `name`: name of the drive. `answers`: an answer to each of the questions. Raises InputError if the values make no
    drive.
    """
    pairs = round(answers["poles"].value)
    stated, inductance = answers["constant"], answers["inductance"]
    constant = FLUX_CONSTANTS[stated.unit]
    values: dict[str, dict[str, tuple[Any, Amount, str]]] = {
        "machine": {
            "pole_pairs": (pairs, answers["poles"], "pairs of poles"),
            "resistance_ohm": _of_phase(answers["resistance"], answers["resistance"].value),
            "direct_inductance_h": _of_phase(inductance, inductance.value),
            "quadrature_inductance_h": _of_phase(inductance, inductance.second or inductance.value),
            "magnet_flux_v_s": (_rounded(constant.flux(stated.value, pairs)), stated, constant.formula),
            "inertia_kg_m2": _converted(answers["inertia"], "in kilogram square metres"),
        },
        "inverter": {
            "link_voltage_v": _converted(
                answers["voltage"],
                "sqrt(2) times the ac voltage" if answers["voltage"].unit == "vac" else "as stated",
            ),
            "carrier_frequency_hz": _converted(answers["frequency"], "in hertz"),
        },
        "rating": {
            "base_speed_rpm": _converted(answers["rated_speed"], "the rated speed"),
            "highest_speed_rpm": _converted(answers["highest_speed"], "the maximum speed"),
            "overspeed_rpm": (
                _rounded(_OVERSPEED * answers["highest_speed"].value),
                answers["highest_speed"],
                "10 % above the maximum speed",
            ),
            "continuous_current_a": _converted(answers["rated_current"], "peak value of a phase"),
            "peak_current_a": _converted(answers["peak_current"], "peak value of a phase"),
        },
    }
    document = {
        "schema": 1,
        "name": name,
        "kind": PM_AC,
        "provenance": {
            table: {key: f"data sheet: {answer.text}; {how}" for key, (_, answer, how) in keys.items()}
            for table, keys in values.items()
        },
        **{table: {key: value for key, (value, _, _) in keys.items()} for table, keys in values.items()},
    }
    return parse_document(document, DriveDocument, "the data sheet")


def _of_phase(answer: Amount, value: float) -> tuple[float, Amount, str]:
    is_phase = answer.unit.endswith("phase")
    return _rounded(value), answer, "one phase" if is_phase else "half of the value between two terminals"


def _converted(answer: Amount, how: str) -> tuple[float, Amount, str]:
    return _rounded(answer.value), answer, how


def _rounded(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")
