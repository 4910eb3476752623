"""What a data sheet prints, taken apart: the number, its unit in the names of the units library, and its words."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from types import MappingProxyType
from typing import Final

from drivegate_cases.documents.quantity.numbers import Number, leading_number, scaled, without_power
from drivegate_cases.documents.quantity.words import split_words, without_conditions

_LONGEST: Final = 200
"""Most characters of a text that is read at all."""
_SIGNS: Final = str.maketrans(
    dict.fromkeys("−–‐‑", "-")
    | dict.fromkeys("⋅∙•", "·")
    | {
        "⁄": "/",
        "[": "(",
        "]": ")",
        "{": "(",
        "}": ")",
        "’": "'",
        "º": "°",
        "˚": "°",
        "⎓": " dc",
        "Ω": "ohm",
        "ω": "ohm",
        "μ": "u",
    }
)
_SUPERSCRIPT: Final = re.compile(r"[⁺⁻⁰¹²³⁴-⁹]+")
_OPEN_POWER: Final = re.compile(r"\(\s*(?=(?:[x×·*]\s*)?10\s*\^?\s*-\s*\d)")
_IN_PARENTHESES: Final = re.compile(r"\s*\(([^()]+)\)\s*")
_LABEL: Final = re.compile(
    r"\s*(?P<label>[^\d=:]*?(?:[rl]_?\d\d)?)\s*[=:]\s*(?=.*\d)|\s*(?P<kv>kv)\s*(?=\d)|\s*(?P<words>[a-z][a-z\s_()/.,-]*?\)?)\s+(?=[\d.])",
    re.IGNORECASE,
)
_HEADER: Final = re.compile(
    r"(?P<name>[a-z_\s.,-]*)\(\s*(?P<unit>[^=:]+)\)\s*[=:]?\s*(?P<value>[\d.,].*)", re.IGNORECASE
)
"""A line of a table, whose unit is in front of the number."""
_OF_PHASE: Final = re.compile(r"(?:.*[\s_])?[rl]_?ph(?:ase)?\b.*")
"""A symbol of one phase, among the words in front of a number."""
_OTHER: Final = re.compile(r"\b(?:minus|less|not|gd|electrical|elec\.?)(?![a-z])", re.IGNORECASE)
"""Words that make another quantity of a number."""
_RPM: Final = re.compile(
    r"(?:(?<![\d.,])1\s*|(?<=\d)\s*|(?:(?<![a-z])|(?<=k))(?:r|revs?|revolutions?|rotations?|u|tr|turns?|tours?|rot)\.?\s*)"
    r"(?:/|\bper\b)\s*min(?:ute)?\b"
    r"|min\s*(?:(?:\^|\*\*)?\s*-1|\^\s*\(-1\))|r\.p\.m\.?|\bupm\b",
    re.IGNORECASE,
)
_RADIANS_PER_SECOND: Final = re.compile(
    r"rad(?:ians?)?\s*(?:/\s*s(?:ec(?:ond)?)?\b|[·.*]?\s*s\s*\^?-1)", re.IGNORECASE
)
_TURNS_PER_SECOND: Final = re.compile(r"(?<![a-z])(?:r|revs?|turns?)\s*/\s*s(?:ec)?\b", re.IGNORECASE)
_DEGREES_PER_SECOND: Final = re.compile(r"(?:deg(?:rees?)?|°)\s*/\s*s(?:ec(?:ond)?)?\b", re.IGNORECASE)
_PREFIX_APART: Final = re.compile(
    r"\b(milli|micro|kilo|[mu])[\s-]+(?=ohms?\b|henr|h\b)|(?<=\d)\s*(k)\s+(?=rpm\b)", re.IGNORECASE
)
_THOUSAND: Final = r"(?:1[\s,.']*000|1?\s*k|10\s*\^\s*3)[\s·*-]*rpm"
_PER_THOUSAND: Final = re.compile(rf"(?:/|\bper\b)\s*(?:\(\s*{_THOUSAND}\s*\)|{_THOUSAND})", re.IGNORECASE)
_AT_THOUSAND: Final = re.compile(r"\s*(?:@|\bat\b)\s*(?=1[\s,.']*000\s*rpm)", re.IGNORECASE)
_TOKEN: Final = re.compile(
    r"(?P<run>[a-z]+)\s*(?P<power>(?:\^|\*\*)\s*\(?[+-]?\d\)?|-?\d)?|(?P<sign>[/()])|(?P<times>[\s·.*×_-]+)",
    re.IGNORECASE,
)
_PREFIXES: Final = MappingProxyType(
    {"m": "milli", "u": "micro", "k": "kilo", "c": "centi", "d": "deci", "n": "nano"}
    | {name: name for name in ("milli", "micro", "kilo", "centi", "nano")}
)
_NAMES: Final = {
    "n newton newtons": "newton",
    "m meter metre meters metres": "meter",
    # A sheet's ounce, pound and gram are of mass or of force; the dimension of the whole unit decides.
    "g gm gram grams": "gram force_gram",
    "oz ounce ounces": "ounce force_ounce",
    "lb lbs pound pounds": "pound force_pound",
    "lbm": "pound",
    "gf": "force_gram",
    "ozf": "force_ounce",
    "lbf": "force_pound",
    "slug": "slug",
    "in inch inches": "inch",
    "ft foot feet": "foot",
    "s sec second seconds": "second",
    "a amp amps ampere amperes": "ampere",
    "v volt volts": "volt",
    "ohm ohms": "ohm",
    "h hy henry henries henrys": "henry",
    "wb weber webers": "weber",
    "hz hertz": "field_hertz",
    "rad radian radians": "shaft_radian",
    "radps": "shaft_radian/second",
    "rps": "shaft_turn/second",
    "degps": "shaft_degree/second",
    "rpm": "shaft_rpm",
    "kv": "shaft_rpm/volt",
}
_UNITS: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {spelling: tuple(names.split()) for spellings, names in _NAMES.items() for spelling in spellings.split()}
)
"""What a unit may be in names of the units library, by each spelling in small letters."""
_WHOLE: Final = re.compile(
    "oz|lbs?|lbm|gm|ozf|lbf|in|inch|inches|ft|foot|feet|rad|radians?|radps|rps|degps|kv"
)
"""Units that take no prefix."""
_MEGA: Final = frozenset({"hz", "hertz"})
"""Units with which a capital M is no mistake."""


@dataclass(frozen=True)
class Spelled:
    """A text taken apart."""

    number: Number
    units: tuple[str, ...]
    """What the unit may be, in names of the units library: each reading of letters that are written together."""
    words: frozenset[str]
    label: str = ""
    """What comes before an equals sign or a colon, in small letters."""


def spelled(text: str) -> Spelled | None:
    """Take a quantity apart; none if the text has no number in front of a unit."""
    if len(text) > _LONGEST or _OTHER.search(text):
        return None
    plain = _OPEN_POWER.sub("", _unit_behind(_plain(text)))
    found = _LABEL.match(plain)
    label = (found["label"] or found["kv"] or found["words"] or "").lower() if found else ""
    plain = _rates(plain[found.end() :] if found else plain)
    plain, words = split_words(without_conditions(plain))
    if label:
        words |= split_words(label)[1] | ({"phase"} if _OF_PHASE.fullmatch(label) else set())
    read = leading_number(plain)
    if read is None:
        return None
    number, unit = read
    unit, exponent = without_power(_IN_PARENTHESES.sub(r"\1", unit))
    unit = unit.strip(" ,;:_")
    if label == "kv" and not unit:
        unit = label
    return Spelled(scaled(number, exponent), tuple(_readings(unit)), words, label)


def _plain(text: str) -> str:
    raised = _SUPERSCRIPT.sub(lambda found: "^" + unicodedata.normalize("NFKC", found[0]), text)
    # Omega and mu have two characters each, which become one here.
    return unicodedata.normalize("NFKC", raised.translate(_SIGNS)).translate(_SIGNS).strip(" ;")


def _unit_behind(text: str) -> str:
    """Move the unit of a table's line behind the number."""
    found = _HEADER.fullmatch(text)
    if found is None:
        return text
    unit = spelled(f"1 {found['unit']}")
    is_unit = unit is not None and unit.units not in ((), ("",))
    return f"{found['name']}: {found['value']} {found['unit']}" if is_unit else text


def _rates(text: str) -> str:
    """Write speeds as one word each, so that a slash in them divides nothing else."""
    for pattern, name in (
        (_RPM, "rpm"),
        (_RADIANS_PER_SECOND, "radps"),
        (_TURNS_PER_SECOND, "rps"),
        (_DEGREES_PER_SECOND, "degps"),
        (_PREFIX_APART, r"\1\2"),
        (re.compile(r"\(\s*rpm\s*\)", re.IGNORECASE), "rpm"),
        (_AT_THOUSAND, "/"),
        (_PER_THOUSAND, "/krpm"),
    ):
        text = pattern.sub(name, text)
    return text


def _readings(unit: str) -> Iterator[str]:
    """Yield what a unit may be, as expressions of the units library; nothing if it is no product of units."""
    if not unit:
        yield ""
        return
    shape: list[str] = []
    runs: list[tuple[str, ...]] = []
    place, is_open = 0, False
    while place < len(unit):
        found = _TOKEN.match(unit, place)
        if found is None:
            return
        place = found.end()
        run = found["run"]
        if found["sign"] or (run and run.lower() == "per"):
            shape.append(found["sign"] or "/")
            is_open = found["sign"] == ")"
        elif run:
            power = re.sub(r"[\s^*()]", "", found["power"] or "")
            runs.append(tuple(f"{read}**({power})" if power else read for read in _run(run)))
            shape += ["*"] * (is_open or shape[-1:] == [")"]) + ["{}"]
            is_open = True
    template = "".join(shape)
    if _is_product(template):
        yield from (template.format(*choice) for choice in product(*runs))


def _run(letters: str) -> Iterator[str]:
    """Yield the products of units that letters written together may be, such as those of mNm."""
    if not letters:
        return
    for length in range(1, len(letters) + 1):
        for first in _unit(letters[:length]):
            if length == len(letters):
                yield first
            else:
                yield from (f"{first}*{rest}" for rest in _run(letters[length:]))


def _unit(letters: str) -> Iterator[str]:
    """Yield what letters are as one unit, with or without a prefix."""
    small = letters.lower()
    yield from (f"({name})" if "/" in name else name for name in _UNITS.get(small, ()))
    for prefix, name in _PREFIXES.items():
        unit = small.removeprefix(prefix)
        if unit == small or unit not in _UNITS or _WHOLE.fullmatch(unit):
            continue
        if letters.startswith("M"):
            if prefix == "m" and unit in _MEGA:
                yield f"mega{_UNITS[unit][0]}"
        else:
            yield from (f"{name}{full}" for full in _UNITS[unit])


def _is_product(template: str) -> bool:
    """Return True if places for units are joined to a product or a quotient."""
    before = ""
    while template != before:
        before, template = template, re.sub(r"\(\{\}\)|\{\}[*/]\{\}", "{}", template)
    return template == "{}"
