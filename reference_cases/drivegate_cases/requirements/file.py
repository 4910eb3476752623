"""The file `requirements.toml`: rows that are judged like checks, and scenarios that are run for them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import Field, model_validator

from drivegate_cases.documents.document import Document, Section, parse_document, read_document
from drivegate_cases.documents.wording import shown_path
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.requirements.ranges import draws_of, has_ranges
from drivegate_cases.requirements.row import LONGEST_RUN_S, Row
from drivegate_cases.scenario.control_periods import on_whole_periods
from drivegate_cases.scenario.scenario import LONGEST_CONTROL_PERIOD_S, Scenario
from drivegate_models.errors import InputError


class Evidence(Section):
    """A requirement of the user's that checks of drivegate show."""

    id: str = Field(min_length=1, max_length=100, description="your own identifier, such as SYS-42")
    checks: tuple[str, ...] = Field(
        min_length=1, description="list of the checks that are evidence for it, such as STP-1"
    )


class RequirementsFile(Document):
    """A file of rows, evidence and scenarios."""

    requirement: tuple[Row, ...] = Field(
        default=(), description="list of requirements, each a table [[requirement]]"
    )
    evidence: tuple[Evidence, ...] = Field(
        default=(),
        description="list of identifiers of yours that checks are evidence for, each a table [[evidence]]",
    )
    scenario: tuple[dict[str, Any], ...] = Field(
        default=(),
        description="list of scenarios that are run besides those of the check, each a table [[scenario]] with the "
        "keys of a scenario but 'schema' and 'drive', which is the one that is checked; a number may be a range "
        "[low, high], from which values are drawn",
    )

    @model_validator(mode="after")
    def _has_each_once(self) -> RequirementsFile:
        if not self.requirement and not self.evidence:
            raise ValueError(
                "the file has no table [[requirement]] or [[evidence]]; write one, or leave the file out"
            )
        identifiers = [entry.id for entry in self.evidence]
        for place, identifier in enumerate(identifiers):
            if identifier in identifiers[:place]:
                raise ValueError(
                    f"two tables [[evidence]] have the id {identifier}; put the checks into one list"
                )
        seen: dict[str, str] = {}
        for row in self.requirement:
            if (other := seen.setdefault(row.id.upper(), row.id)) is not row.id:
                raise ValueError(f"two requirements are called {other}; give each an id of its own")
        return self


@dataclass(frozen=True)
class OwnRequirements:
    """What a user requires, as it travels with a candidate."""

    rows: tuple[Row, ...]
    scenarios: tuple[str, ...] = ()
    """Each as JSON, without its drive."""
    evidence: tuple[Evidence, ...] = ()
    """The user's identifiers of what checks of drivegate show."""
    where: str = "requirements.toml"
    """The file, as messages name it."""

    def scenarios_on(self, drive: DriveDocument) -> tuple[Scenario, ...]:
        """Return the scenarios without ranges."""
        tables = [(number, json.loads(text)) for number, text in enumerate(self.scenarios, start=1)]
        return tuple(self._made(drive, [entry for entry in tables if not has_ranges(entry[1])]))

    def drawn_on(self, drive: DriveDocument, count: int, seed: int) -> tuple[Scenario, ...]:
        """Draw so many scenarios from each with ranges; the first two have the ends of all ranges."""
        tables = [(number, json.loads(text)) for number, text in enumerate(self.scenarios, start=1)]
        drawn = [
            (number, values)
            for number, table in tables
            if has_ranges(table)
            for values in draws_of(table, count, seed)
        ]
        return tuple(self._made(drive, drawn))

    def _made(self, drive: DriveDocument, tables: Iterable[tuple[int, dict[str, Any]]]) -> Iterator[Scenario]:
        for number, stated in tables:
            table = {"schema": Scenario.schema_current, **stated, "drive": drive.to_mapping()}
            period, duration = drive.control_period_s or LONGEST_CONTROL_PERIOD_S, table.get("duration_s")
            if (
                isinstance(duration, float | int)
                and 0.0 < duration <= LONGEST_RUN_S
                and "control_period_s" not in table
            ):
                # Nobody who writes the file knows the control period of every drive.
                table["duration_s"] = on_whole_periods(float(duration), period)
            yield parse_document(table, Scenario, f"{self.where}, scenario {number}")


def read_requirements(path: str | Path) -> OwnRequirements:
    """Read a file of requirements; what it says of a drive is checked when there is one."""
    read = read_document(path, RequirementsFile)
    for number, table in enumerate(read.scenario, start=1):
        for key in ("drive", "schema"):
            if key in table:
                raise InputError(
                    f"{shown_path(path)}: scenario {number} has the key '{key}', but must leave it out, since it is "
                    "run on the drive that is checked"
                )
    return OwnRequirements(
        read.requirement,
        tuple(json.dumps(table, sort_keys=True) for table in read.scenario),
        read.evidence,
        shown_path(path),
    )
