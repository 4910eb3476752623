"""A question whose answer is a quantity: what it accepts, and what it says of an answer that it does not understand."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from math import isfinite
from typing import Final

from drivegate_cases.documents.quantity.numbers import Number
from drivegate_cases.documents.quantity.spelling import Spelled, spelled
from drivegate_cases.documents.quantity.units import size
from drivegate_cases.documents.quantity.words import split_words
from drivegate_cases.documents.wording import one_line
from drivegate_models.errors import InputError

_LONGEST: Final = 60
_POINT_MAY_GROUP: Final = frozenset({"", "shaft_rpm", "field_hertz"})
"""Units of numbers so large that a point before three digits may separate thousands."""
_SPEED_PER_VOLT: Final = "shaft_rpm/volt"
_LABEL: Final = re.compile(r"\s*l_?[dq]\s*[/,&=]\s*l_?[dq]\b[^\d=:]*[=:]?\s*", re.IGNORECASE)
_OF_ONE_PHASE: Final = re.compile(r"(?:.*\s)?(?:[rl]_?[adqs1]|[dq]-axis)\b.*")
"""A symbol that is mostly of one phase, among the words in front of a number."""
_NEXT: Final = re.compile(
    r"\s*(?:/|;|,\s|\band\b|\s(?=l_?[dq]))\s*(?=(?:l_?[dq]\s*[=:]?\s*)?[\d.])", re.IGNORECASE
)
_NAME: Final = re.compile(r"[\s(]*l_?(?P<axis>[dq])(?![a-z])\s*\)?", re.IGNORECASE)
"""Name of one inductance of a pair, before or behind its number."""


@dataclass(frozen=True)
class Reading:
    """One way in which an answer may be meant."""

    unit: str
    """A unit of the quantity, in names of the units library; the answer may have any other of the same quantity."""
    words: frozenset[str] = frozenset()
    """Words that the answer must have, of those of `split_words`."""
    factor: float = 1.0
    """The value over the number in `unit`, or over its inverse."""
    how: str = "as stated"
    """The conversion, as a drive's file states it."""
    is_inverse: bool = False
    needless: frozenset[str] = frozenset()
    """Words that change nothing."""

    def value(self, number: float, unit: str) -> float | None:
        """Convert a number with a unit; none if that is of another quantity."""
        scale = size(unit, self.unit)
        if scale is None:
            return None
        stated = number * scale
        return self.factor * (1.0 / stated if self.is_inverse and stated else stated)


@dataclass(frozen=True)
class Amount:
    """One answer as it was read."""

    value: float
    """The converted value."""
    text: str
    how: str
    """The conversion, as a drive's file states it."""
    unit: str = ""
    """The unit of the reading that fitted."""
    second: float | None = None
    """Second value of a pair."""


@dataclass(frozen=True)
class Question:
    """One line of a data sheet."""

    quantity: str
    """What is asked for."""
    examples: str
    """Answers that would do."""
    accepted: str
    """All units, and the words that go with them."""
    readings: tuple[Reading, ...] = ()
    missing: str = ""
    """What is to be added to an answer that leaves something open."""
    default: str = ""
    """The answer where none is given; empty for a question that requires one."""
    bare_unit: str = ""
    """Unit of a number without one; empty where a unit is required."""

    def read(self, text: str) -> Amount:
        """Read an answer.

        Raises InputError if it is no number above 0 with one of the units, or may mean two things.
        """
        return self._amount(text, self._parts(text))

    def _parts(self, text: str) -> tuple[Spelled, ...]:
        found = spelled(text)
        return () if found is None else (found,)

    def _amount(self, text: str, parts: tuple[Spelled, ...]) -> Amount:
        if not parts or not all(part.units for part in parts):
            raise self._not_understood(text)
        words = frozenset[str]().union(*(part.words for part in parts))
        self._refuse_two_meanings(text, parts)
        if not words & {"phase", "line"} and any(_OF_ONE_PHASE.fullmatch(part.label) for part in parts):
            raise self._not_understood(text, self.missing)
        fitting = [
            (reading, values)
            for reading in self.readings
            if (values := self._values(reading, parts)) is not None
        ]
        chosen = [found for found in fitting if found[0].words == words - found[0].needless]
        if not chosen:
            is_open = any(words < reading.words | reading.needless for reading, _ in fitting)
            raise self._not_understood(text, self.missing if is_open else "")
        reading, values = chosen[0]
        if not all(isfinite(value) and value > 0.0 for value in values):
            raise InputError(f"{self.quantity}: {_quoted(text)} must be above 0 and finite")
        second = values[1] if len(values) > 1 else None
        return Amount(values[0], one_line(text).strip(), reading.how, reading.unit, second)

    def _values(self, reading: Reading, parts: Iterable[Spelled]) -> tuple[float, ...] | None:
        """Convert all numbers by one reading; none if a unit is of another quantity."""
        values = []
        for part in parts:
            found = (reading.value(part.number.value, unit or self.bare_unit) for unit in part.units)
            value = next((value for value in found if value is not None), None)
            if value is None:
                return None
            values.append(value)
        return tuple(values)

    def _refuse_two_meanings(self, text: str, parts: Iterable[Spelled]) -> None:
        for part in parts:
            number = part.number
            if number.grouped is not None and (number.is_open or _may_group(number, part.units[0])):
                raise InputError(
                    f"{self.quantity}: {_quoted(text)} may mean {number.value:g} or {number.grouped:g}; write it "
                    f"without a separator of thousands, as {_plain(number)} or {number.grouped:.0f}"
                )

    def _not_understood(self, text: str, missing: str = "") -> InputError:
        hint = missing or f"{self._mega(text)}; write a number with its unit, such as {self.examples}"
        return InputError(
            f"{self.quantity}: {_quoted(text)} is not understood{hint}; accepted: {self.accepted}"
        )

    def _mega(self, text: str) -> str:
        small = text.replace("M", "m")
        parts = self._parts(small) if small != text else ()
        is_milli = parts and all(part.units for part in parts)
        fits = is_milli and any(self._values(reading, parts) is not None for reading in self.readings)
        return ", since a capital M is mega and milli is m" if fits else ""


class PairQuestion(Question):
    """A question that two numbers may answer, such as L_d/L_q."""

    def _parts(self, text: str) -> tuple[Spelled, ...]:
        whole = super()._parts(text)
        if whole and whole[0].units:
            return whole
        found = _LABEL.match(text)
        label, values = (found[0], text[found.end() :]) if found else ("", text)
        texts = _NEXT.split(values, maxsplit=1)
        if len(texts) == 1:
            # Both are equal.
            return super()._parts(f"ld: {values}") if found else whole
        names = [found["axis"].lower() if (found := _NAME.search(part)) else "" for part in texts]
        first, second = (spelled(_NAME.sub(" ", part)) for part in texts)
        if first is None or second is None:
            return ()
        units = second.units if first.units == ("",) else first.units
        if not (first.words | second.words | split_words(label)[1]):
            raise self._not_understood(text, self.missing)
        pair = Spelled(first.number, units, first.words | split_words(label)[1]), second
        is_reversed = names[0] == "q" or bool(re.match(r"\s*l_?q\b", label, re.IGNORECASE))
        return pair[::-1] if is_reversed else pair


def _may_group(number: Number, unit: str) -> bool:
    """Return True if a point before three digits may separate thousands; of a Kv only if it is 1000 to 9999."""
    return unit in _POINT_MAY_GROUP or (number.value < 10.0 and unit.strip("()") == _SPEED_PER_VOLT)


def _quoted(text: str) -> str:
    return f"'{one_line(text)[:_LONGEST]}'"


def _plain(number: Number) -> str:
    return f"{number.value:.1f}" if number.value == round(number.value) else f"{number.value:g}"
