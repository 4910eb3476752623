"""What a quantity of a drive is drawn within, and what its value is measured by; the tables are CSV files."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from decimal import Decimal
from importlib.resources import files
from math import prod
from random import Random
from typing import Any, Final

from drivegate_cases.documents.rounding import significant
from drivegate_models.units import RADIANS_PER_RPM

DIGITS: Final = 3
"""Digits that a drawn value is rounded to, so that its file reads well."""


class Values(dict[str, Any]):
    """Values of a drive by their keys as far as they are known, and what follows from them.

    A kind of drive adds what only it has: `voltage`, the greatest one of a phase (V), and names of its table.
    """

    def __missing__(self, name: str) -> float:
        if name == "seconds":
            return 60.0
        if name == "speed":
            return float(self["base_speed_rpm"] * RADIANS_PER_RPM)
        if name == "electrical_speed":
            return float(self["pole_pairs"] * self["speed"])
        if name == "torque":
            return float(self["rated_power_w"] / self["speed"])
        if name == "impedance":
            return float(self["voltage"] / self["current_limit_a"])
        raise KeyError(name)


@dataclass(frozen=True)
class Bound:
    """What one quantity of a drive is drawn within: a row of a table."""

    key: str
    """Key of the document that follows from it; empty where it only narrows another one."""
    per_unit: str
    """Product of values, and after a slash of those that it is divided by; empty for the size of the drive."""
    lowest: float
    highest: float
    """The range."""
    evenly_by: str
    """What is equally likely: differences, ratios or whole numbers."""
    quantity: str
    """The quantity, in words."""
    unit: str
    """Its unit, or what it is a share of."""
    reason: str
    """Why the range is that."""

    def drawn(self, source: Random) -> float:
        """Draw a value."""
        return self.between(source, self.lowest, self.highest)

    def between(self, source: Random, lowest: float, highest: float) -> float:
        """Draw a value from a part of the range."""
        if self.evenly_by == "whole number":
            return source.randint(round(lowest), round(highest))
        if self.evenly_by == "ratio":
            # A decimal's logarithm is the same on every processor, a library's may not be.
            first, last = Decimal(lowest).ln(), Decimal(highest).ln()
            return rounded(float((first + (last - first) * Decimal(source.random())).exp()))
        return rounded(source.uniform(lowest, highest))

    def value(self, drawn: float, values: Values) -> float:
        """Return the value of the key from a drawn number and what is known of the drive."""
        if not self.per_unit:
            return drawn
        (_, *factors), divisors = self._terms(values)
        return rounded(drawn * prod(divisors) / prod(factors))

    def measured(self, values: Values) -> float | None:
        """Return the value per unit; None where the drive has none."""
        if not self.per_unit or values.get(self.key, 0.0) is None:
            return None
        factors, divisors = self._terms(values)
        return float(prod(factors) / prod(divisors))

    def sentence(self, measured: float | None) -> str:
        """Return what was drawn; a value that the document itself states is left out."""
        within = f"from {self.lowest:g} to {self.highest:g}{self.unit and ' '}{self.unit}"
        return f"drawn: {within}" if measured is None else f"drawn: {self.quantity} {measured:.3g}, {within}"

    def _terms(self, values: Values) -> tuple[list[float], list[float]]:
        factors, _, divisors = self.per_unit.partition("/")
        first, *others = factors.split()
        return [values.get(first, 0.0), *(values[name] for name in others)], [
            values[name] for name in divisors.split()
        ]


def bounds_of(kind: str) -> dict[str, Bound]:
    """Read the table of a kind of drive, in the order in which its quantities are drawn."""
    found: dict[str, Bound] = {}
    lines = (files(__package__) / f"{kind}.csv").read_text(encoding="utf-8").splitlines()
    for row in csv.DictReader(lines):
        name, lowest, highest = row.pop("name"), float(row.pop("lowest")), float(row.pop("highest"))
        found[name] = Bound(lowest=lowest, highest=highest, **row)
    return found


def rounded(value: float) -> float:
    """Round a drawn value, or what follows from drawn values."""
    return significant(value, DIGITS)
