"""The words around a number that say of what it is, such as rms or line to line, and those that change nothing."""

from __future__ import annotations

import re
from types import MappingProxyType
from typing import Final

_AMOUNT: Final = r"[+-]?\d+(?:[.,]\d+)?"
_OF_TEMPERATURE: Final = r"(?:°\s*[CFK]?|deg\.?\s*[CF]|[CK]\b)"
_MEASURED: Final = rf"{_AMOUNT}\s*(?:{_OF_TEMPERATURE}|[km]?Hz|k?rpm|min\^?-1|m?V\s*(?:dc|ac|rms)?\b|m?A\b)"
# A comma between digits is one of decimals.
_APART: Final = r"(?:(?<!\d),|,\s|[;(])\s*"
_CONDITION: Final = re.compile(
    rf"\(\s*1\s*±\s*{_AMOUNT}\s*%\s*\)|\(?\s*(?:±|\+\s*/\s*-|\+-)\s*{_AMOUNT}\s*%?"
    rf"|[,;(]?\s*(?:@|\bat\b)\s*{_MEASURED}(?:\s*(?:[,;/]|\band\b)\s*{_MEASURED})*"
    rf"|[,;(]?\s*{_AMOUNT}\s*(?:°\s*[CF]\b|deg\.?\s*C\b)|{_APART}{_AMOUNT}\s*k?Hz\b"
    rf"|(?:{_APART}|\s*\bfor\b\s*){_AMOUNT}\s*(?:s|sec|seconds?|min|minutes?)\b\.?"
    r"|(?<=\S)[\s,;(]+[56]0(?:\s*/\s*60)?\s*Hz\b|[,;(\s]\s*\d{1,2}\s*S\b(?:\s*Li-?\w*)?",
    re.I,
)
_TOLERANCE_WITH_UNIT: Final = re.compile(
    rf"(?P<unit>\b[a-z][^\s()±+]*)\s*\(?\s*(?:±|\+\s*/\s*-|\+-)\s*{_AMOUNT}\s*(?P=unit)(?![a-z])", re.I
)
_VAGUE: Final = re.compile(r"^\s*(?:[~≈≤<]|approx\.?|ca\.?|about|up to)\s*(?=\d)", re.I)
_EMPTY: Final = re.compile(r"\(\s*[,;/-]*\s*\)")
_TO: Final = r"[-\s/]*(?:to)?[-\s/]*"
_PHASE: Final = r"ph(?:ase)?"
_TERMINALS: Final = r"term(?:inal)?s?\b\.?"
# A word may follow the letter of its unit directly, as in Arms, Vdc and V_peak, or come before it.
_BEFORE: Final = r"(?:(?<=[AV_])(?<![A-JLN-TV-Z][AV])|(?<![A-Z]))"
_AFTER: Final = r"(?:(?![A-Z])|(?=[AV](?![A-Z])))"
_SLASHED: Final = MappingProxyType(
    {"phase": "/ *ph(?:ase)?", "ac": rf"/ *[13]\s*{_PHASE}", "line": rf"/ *{_PHASE}{_TO}{_PHASE}"}
)
_PATTERNS: Final = (
    ("peak to peak", r"p-?p|pk-?pk|peak[-\s]*to[-\s]*peak"),
    (
        "ac",
        rf"(?<![\d.,])(?:[13]|one|single|three)\s*(?:-?\s*{_PHASE}s?|~|ac|[x×](?=\s*\d+\s*V))|ac|(?<=V)\s*~",
    ),
    (
        "line",
        rf"line{_TO}line|l\s*[-/]?\s*l|{_PHASE}{_TO}{_PHASE}|t[-/]t|u[-/]v"
        rf"|two[-\s]*phases?|(?:between\s*)?(?:two\s*)?(?:{_TERMINALS})(?:{_TO}{_TERMINALS})?"
        r"|between\s*(?:two\s*)?(?:phases|lines)",
    ),
    (
        "phase",
        rf"(?:line|l|{_PHASE}){_TO}(?:neutral|n)|(?:per|of|one|of one)\s+{_PHASE}|{_PHASE}",
    ),
    ("line", "line"),
    ("peak", r"(?:0|o|zero)\s*-?\s*(?:to)?[\s-]*(?:peak|pk|p)|peak|pk|crest|amplitude|(?<=[AV])p"),
    ("rms", r"rms|r\.m\.s\.?|eff(?:ective)?"),
    ("dc", r"dc|d\.c\."),
    ("supply", r"(?:bus|link|supply|battery)(?:\s*voltage)?"),
    ("no load", r"(?:at\s*)?no[-\s]*load|unloaded"),
    (
        "",
        r"(?:no|w/o|without|with)[-\s]*brake|limit|pwm|ambient|trapezoidal|block(?:\s*commutation)?|cent(?:er|re)[-\s]aligned|of(?=\s*sine)"
        r"|max(?:imum)?\.?|nom(?:inal)?\.?|rated|typ(?:ical)?\.?|cold|mech(?:anical)?\.?|sin(?:e|usoidal)"
        r"|cont(?:inuous)?\.?|stall|S1",
    ),
)
_WORDS: Final = tuple(
    # The slash of "per phase" follows a unit, whose letters come before it.
    (
        word,
        re.compile(
            rf"{_SLASHED.get(word, '(?!)')}{_AFTER}|{_BEFORE}_?(?:{pattern}){_AFTER}",
            re.I,
        ),
    )
    for word, pattern in _PATTERNS
)


def without_conditions(text: str) -> str:
    """Drop tolerances, and the temperature, frequency or speed at which a value was measured."""
    text = _TOLERANCE_WITH_UNIT.sub(r"\g<unit>", text)
    return _EMPTY.sub(" ", _balanced(_VAGUE.sub("", _CONDITION.sub("", text))))


def split_words(text: str) -> tuple[str, frozenset[str]]:
    """Return a text without the words that qualify it, and those words by their common names.

    The names are rms, peak, dc, ac, line (between two terminals) and phase (of one), peak to peak, supply and no load.
    """
    found = set()
    for word, pattern in _WORDS:
        rest = pattern.sub(" ", text)
        if rest != text and word:
            found.add(word)
        text = rest
    return _EMPTY.sub(" ", text).strip(" ,;:_="), frozenset(found)


def _balanced(text: str) -> str:
    """Drop the parenthesis that a condition leaves open or closed."""
    if text.count(")") == text.count("(") + 1:
        return text[: text.rfind(")")] + text[text.rfind(")") + 1 :]
    return text
