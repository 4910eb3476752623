"""A PM AC drive from what a data sheet states: each answer is converted, and the drive says how."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import pi, sqrt
from types import MappingProxyType
from typing import Any, Final

from drivegate_cases.documents.document import parse_document
from drivegate_cases.documents.quantity.poles import PolesQuestion
from drivegate_cases.documents.quantity.question import Amount, PairQuestion, Question, Reading
from drivegate_cases.drive.drive_document import PM_AC, DriveDocument

_DIGITS: Final = 5
"""Digits of a converted value: more than any data sheet states."""
_OVERSPEED: Final = 1.1
"""Highest speed of all over the highest speed of the data sheet (1)."""
_SQRT2, _SQRT3 = sqrt(2.0), sqrt(3.0)
_PER_DC: Final = 2.0 / _SQRT3
"""Peak current of a sine over the direct current through two phases that produces the same torque (1)."""


def _word(*names: str) -> frozenset[str]:
    return frozenset(names)


_OF_STAR: Final = _word("phase", "line")
_TORQUE: Final = "newton*meter/ampere"
_EMF: Final = "volt*second/shaft_radian"
_SPEED: Final = "shaft_radian/second/volt"
_PER_HERTZ: Final = "volt/field_hertz"
_LINKAGE: Final = "volt*second"
_OF_FLUX: Final = frozenset({_PER_HERTZ, _LINKAGE})
"""Units of constants that do not depend on the number of pole pairs."""


def _constants() -> Iterator[Reading]:
    """Yield the constants of a machine, each with its factor to the flux linkage, or to that times the pole pairs."""
    dc = "since Kt of a dc current is the peak EMF between two terminals over speed"
    yield Reading(
        _TORQUE, _word("rms"), 1.0 / (1.5 * _SQRT2), "Kt / (1.5 sqrt(2) pole pairs)", needless=_OF_STAR
    )
    yield Reading(_TORQUE, _word("peak"), 1.0 / 1.5, "Kt / (1.5 pole pairs)", needless=_OF_STAR)
    yield Reading(_TORQUE, _word("dc"), 1.0 / _SQRT3, f"Kt / (sqrt(3) pole pairs), {dc}", needless=_OF_STAR)
    yield Reading(_LINKAGE, _word(), 1.0, "in volt seconds, peak of a phase", needless=_word("peak", "phase"))
    yield Reading(_LINKAGE, _word("rms"), _SQRT2, "sqrt(2) times the volt seconds", needless=_word("phase"))
    hertz = "with the EMF of a phase over the electrical frequency"
    yield Reading(
        _PER_HERTZ, _word(), 0.5 / pi, f"V/Hz / (2 pi), {hertz}, peak value", needless=_word("peak", "phase")
    )
    yield Reading(
        _PER_HERTZ,
        _word("rms"),
        _SQRT2 / (2.0 * pi),
        f"V/Hz sqrt(2) / (2 pi), {hertz}",
        needless=_word("phase"),
    )
    for place, divisor, over, needless in (
        (_word(), _SQRT3, "sqrt(3) ", _word("line")),
        (_word("phase"), 1.0, "", _word()),
    ):
        of = "of a phase" if place else "between two terminals"
        for kind, factor, times in (("rms", _SQRT2, "sqrt(2) "), ("peak", 1.0, ""), ("dc", 1.0, "")):
            emf = f"of the {'rms' if kind == 'rms' else 'peak'} EMF {of}"
            words = place | {kind}
            how = f"{times or '1 '}/ ({over}pole pairs Kv) with Kv in rad/s per volt {emf}"
            yield Reading(_SPEED, words, factor / divisor, how, True, needless)
            how = f"Ke {times}/ ({over}pole pairs) with Ke in V·s/rad {emf}"
            yield Reading(_EMF, words, factor / divisor, how, needless=needless)
        how = f"1 / ({over}pole pairs Kv) with Kv in rad/s per volt of the peak EMF {of}"
        yield Reading(_SPEED, place, 1.0 / divisor, how, True, needless | {"no load"})


def _of_winding(unit: str) -> tuple[Reading, ...]:
    """Return the readings of a resistance or an inductance, which is of two phases unless a word says otherwise."""
    return (
        Reading(unit, _word(), 0.5, "half of the value between two terminals", needless=_word("line")),
        # Of a winding, p-p is from phase to phase.
        Reading(unit, _word("peak to peak"), 0.5, "half of the value between two terminals"),
        Reading(unit, _word("phase"), 1.0, "one phase"),
    )


def _currents() -> tuple[Reading, ...]:
    return (
        Reading(
            "ampere", _word("rms"), _SQRT2, "sqrt(2) times the rms value", needless=_OF_STAR | _word("ac")
        ),
        Reading("ampere", _word("peak"), 1.0, "peak value of a phase", needless=_OF_STAR),
        Reading(
            "ampere",
            _word("dc"),
            _PER_DC,
            "I_peak = 1.155 I_dc: the direct current through two phases that produces the same torque",
        ),
    )


_OF_CURRENT: Final = ": say whether it is 'rms' or 'peak', or 'dc' (I_peak = 1.155 I_dc)"
_CURRENT_UNITS: Final = "A or mA with rms, peak or dc; I_peak = 1.414 I_rms = 1.155 I_dc"
_RPM: Final = (Reading("shaft_rpm", how="in turns a minute", needless=_word("no load")),)
_RPM_UNITS: Final = "rpm, r/min, 1/min, min-1, krpm or rad/s"
QUESTIONS: Final[Mapping[str, Question]] = MappingProxyType(
    {
        "poles": PolesQuestion(
            "number of poles", "'8 poles' or '4 pairs'", "8, 8 poles, 8P, 12N8P, 4 pairs or 4 pole pairs"
        ),
        "constant": Question(
            "Kv, Kt or Ke",
            "'84 rpm/V' or '0.12 N·m/A rms'",
            "N·m/A, mN·m/A, oz-in/A, lb-in/A with rms, peak or dc; V/krpm, mV/rpm, V·s/rad with rms or peak, perhaps "
            "of a phase; rpm/V; V/Hz, V·s, Wb, mWb of a phase",
            tuple(_constants()),
            ": add 'rms', 'peak' or, for Kt of a dc current, 'dc'",
        ),
        "resistance": Question(
            "resistance between two terminals",
            "'0.42 ohm', '420 mohm' or, of one phase, '0.21 ohm phase'",
            "ohm, mΩ, µΩ, alone or with l-l, line-line or terminal, or with phase or l-n",
            _of_winding("ohm"),
            ": of R_s, add 'phase' or 'line-line'",
        ),
        "inductance": PairQuestion(
            "inductance between two terminals",
            "'1.2 mH', of one phase '0.6 mH phase', or L_d/L_q of one phase '0.5/0.8 mH phase'",
            "H, mH, µH, alone or with l-l, line-line or terminal, or with phase or l-n",
            _of_winding("henry"),
            ": of L_s or of L_d/L_q, add 'phase' or 'line-line'",
        ),
        "inertia": Question(
            "inertia of rotor and load",
            "'120 g·cm²' or '0.3 kg·cm²'",
            "kg·m², kg·cm², g·cm², oz-in², oz-in-s², lb-in², lb-in-s², lb-ft², also with × 10⁻⁴",
            (Reading("kilogram*meter**2", how="in kilogram square metres"),),
        ),
        "rated_current": Question(
            "rated current", "'5 A rms' or '7.1 A peak'", _CURRENT_UNITS, _currents(), _OF_CURRENT
        ),
        "peak_current": Question(
            "maximum current", "'15 A rms' or '21 A peak'", _CURRENT_UNITS, _currents(), _OF_CURRENT
        ),
        "voltage": Question(
            "supply voltage",
            "'48 V', or '230 V ac' for a rectified supply",
            "V, V dc, kV, or V ac or V rms of a rectified supply",
            (
                Reading("volt", needless=_word("dc", "supply")),
                Reading(
                    "volt",
                    _word("ac"),
                    _SQRT2,
                    "sqrt(2) times the ac voltage",
                    needless=_word("rms", "line", "supply"),
                ),
                Reading(
                    "volt",
                    _word("rms"),
                    _SQRT2,
                    "sqrt(2) times the ac voltage",
                    needless=_word("line", "supply"),
                ),
            ),
        ),
        "rated_speed": Question("rated speed", "'3000 rpm'", _RPM_UNITS, _RPM, bare_unit="shaft_rpm"),
        "highest_speed": Question("maximum speed", "'4500 rpm'", _RPM_UNITS, _RPM, bare_unit="shaft_rpm"),
        "frequency": Question(
            "PWM frequency of your inverter",
            "'20 kHz'",
            "Hz, kHz or MHz",
            (Reading("field_hertz", how="in hertz"),),
            default="20 kHz",
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
    constant, inductance = answers["constant"], answers["inductance"]
    flux = constant.value if constant.unit in _OF_FLUX else constant.value / pairs
    highest = answers["highest_speed"]
    values: dict[str, dict[str, tuple[Any, Amount, str]]] = {
        "machine": {
            "pole_pairs": (pairs, answers["poles"], answers["poles"].how),
            "resistance_ohm": _converted(answers["resistance"]),
            "direct_inductance_h": _converted(inductance),
            "quadrature_inductance_h": _converted(inductance, inductance.second),
            "magnet_flux_v_s": _converted(constant, flux),
            "inertia_kg_m2": _converted(answers["inertia"]),
        },
        "inverter": {
            "link_voltage_v": _converted(answers["voltage"]),
            "carrier_frequency_hz": _converted(answers["frequency"]),
        },
        "rating": {
            "base_speed_rpm": (*_converted(answers["rated_speed"])[:2], "the rated speed"),
            "highest_speed_rpm": (*_converted(highest)[:2], "the maximum speed"),
            "overspeed_rpm": (_rounded(_OVERSPEED * highest.value), highest, "10 % above the maximum speed"),
            "continuous_current_a": _converted(answers["rated_current"]),
            "peak_current_a": _converted(answers["peak_current"]),
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


def _converted(answer: Amount, value: float | None = None) -> tuple[float, Amount, str]:
    return _rounded(answer.value if value is None else value), answer, answer.how


def _rounded(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")
