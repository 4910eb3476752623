"""Drives drawn at random within the bounds of their kind, only those whose rating can be met."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from decimal import Decimal
from importlib.resources import files
from math import prod
from random import Random
from typing import Any, Final

from drivegate_cases.documents.wording import significant
from drivegate_cases.drive.data_sheet import Provenance
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_models.errors import HarnessFault
from drivegate_models.units import RADIANS_PER_RPM

DIGITS: Final = 3
"""Digits that a drawn value is rounded to, so that its file reads well."""
MOST_DRAWS: Final = 1000
"""Draws after which the bounds, not chance, must be what is wrong."""


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
    """What is equally likely: differences, ratios, whole numbers or ratios of those."""
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
        if self.evenly_by.startswith("ratio"):
            # A decimal's logarithm is the same on every processor, a library's may not be.
            first, last = Decimal(lowest).ln(), Decimal(highest).ln()
            drawn = float((first + (last - first) * Decimal(source.random())).exp())
            return round(drawn) if self.evenly_by == "ratio of whole numbers" else rounded(drawn)
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


@dataclass(frozen=True)
class DrawnDrive:
    """A drive that was drawn."""

    document: DriveDocument
    """The drive."""
    rejected: int
    """Number of drives that were drawn before it and have a rating that no controller can meet."""


@dataclass(frozen=True, kw_only=True)
class DrawnKind:
    """How drives of a kind are drawn."""

    kind: str
    """The kind, as documents have it."""
    document: type[DriveDocument]
    """The documents of such drives."""
    seed: str
    """Text before seed and number, so that kinds are drawn independently."""
    names: str
    """Begin of the drives' names."""
    bounds: Mapping[str, Bound]
    """What each quantity is drawn within, by its name and in the order in which they are drawn."""
    draws_of: Mapping[str, Callable[[Bound, Random, Values], None]]
    """By the names of bounds, what draws the values where that is not a number times what it is measured by."""
    measured_by: Callable[[DriveDocument], dict[str, float]]
    """Return what the table names in addition to keys of the document."""
    remarks: Mapping[str, str]
    """For keys that follow from no bound, where their values come from."""
    accepted: Callable[[DriveDocument], DriveDocument | None]
    """Return a drive on which controllers can be judged; None where none can meet its rating."""

    def draw(self, seed: int, number: int) -> DrawnDrive:
        """Draw a drive whose rating can be met; it follows from seed and number alone."""
        for rejected, document in zip(range(MOST_DRAWS), self.draws(seed, number), strict=False):
            if (found := self.accepted(document)) is not None:
                return DrawnDrive(found, rejected)
        raise HarnessFault(
            f"none of {MOST_DRAWS} drives drawn with seed {seed} for number {number} meets its rating"
        )

    def draws(self, seed: int, number: int) -> Iterator[DriveDocument]:
        """Draw drives without end, whether or not their rating can be met."""
        source = Random(f"{self.seed}{seed}/{number}")
        while True:
            yield self._document(f"{self.names}{seed}-{number:03d}", source)

    def per_unit(self, drive: DriveDocument) -> dict[str, float]:
        """Return a drive's values without its size, by the names of the bounds."""
        keys = (bound.key for bound in self.bounds.values() if bound.key)
        values = Values({key: drive.value(key) for key in keys} | self.measured_by(drive))
        found = {name: bound.measured(values) for name, bound in self.bounds.items()}
        return {name: value for name, value in found.items() if value is not None}

    def _document(self, name: str, source: Random) -> DriveDocument:
        """Draw all values in a fixed order, so that a seed means the same drive for ever."""
        values = Values()
        for quantity, bound in self.bounds.items():
            if (draw := self.draws_of.get(quantity)) is not None:
                draw(bound, source, values)
            elif bound.key:
                values[bound.key] = bound.value(bound.drawn(source), values)
        tables = {
            table: {key: values[key] for key in model.model_fields if key in values}
            for table, model in self.document.tables.items()
        }
        stated = {table: keys for table, keys in tables.items() if keys}
        drawn = self.document.model_validate({"schema": 1, "name": name, "kind": self.kind, **stated})
        return drawn.replaced(provenance=self._provenance(drawn))

    def _provenance(self, drive: DriveDocument) -> Provenance:
        """State for each value what was drawn, and within which bounds."""
        measured, remarks = self.per_unit(drive), dict(self.remarks)
        remarks |= {
            bound.key: bound.sentence(measured.get(name)) for name, bound in self.bounds.items() if bound.key
        }
        found: dict[str, dict[str, str]] = {}
        for key, table in sorted(drive.table_of_key().items(), key=lambda row: row[0] in self.remarks):
            if key in remarks and drive.value(key) is not None:
                found.setdefault(table, {})[key] = remarks[key]
        return found
