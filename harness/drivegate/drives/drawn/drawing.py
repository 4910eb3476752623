"""Drives drawn at random within the bounds of their kind, only those whose rating can be met."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from random import Random
from typing import Final

from drivegate.drives.drawn.bounds import Bound, Values
from drivegate_cases.drive.data_sheet import Provenance
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_models.errors import HarnessFault

MOST_DRAWS: Final = 1000
"""Draws after which the bounds, not chance, must be what is wrong."""


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
        measured, told = self.per_unit(drive), dict(self.remarks)
        told |= {
            bound.key: bound.sentence(measured.get(name)) for name, bound in self.bounds.items() if bound.key
        }
        found: dict[str, dict[str, str]] = {}
        for key, table in sorted(drive.table_of_key().items(), key=lambda row: row[0] in self.remarks):
            if key in told and drive.value(key) is not None:
                found.setdefault(table, {})[key] = told[key]
        return found
