"""What ``drivegate bench`` keeps: the document, how it is read again, and how two of them are compared."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import Any, ClassVar, Final, Literal

from pydantic import Field

from drivegate.results.provenance import machine, provenance
from drivegate.results.result import finite
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.document import Document, Section, read_document
from drivegate_lab.bench.workbench import Better

SCHEMA: Final = 1
"""Version of the document."""

Table = dict[str, Any]
Number = float | None


class BenchRow(Section):
    """One measured number."""

    name: str = Field(description="its name")
    title: str = Field(description="what it is")
    setting: str = Field(description="what the work was")
    unit: str = Field(description="its unit")
    better: Better = Field(description="which way it is better")
    bar: Number = Field(description="what it is meant to reach on an ordinary machine")
    value: Number = Field(description="best of all rounds; null where it was not measured")
    median: Number = Field(description="median of all rounds")
    rounds: int = Field(ge=0, description="number of rounds")
    valid: bool | None = Field(description="whether the work gave the right result")
    check: str = Field(description="what was looked at for that, or why nothing was measured")
    earlier: Number = Field(default=None, description="the number that it was compared with")
    times_as_good: Number = Field(default=None, description="above 1 where it is better than the earlier one")


class BenchDocument(Document):
    """What was measured at one time on one machine."""

    schema_current: ClassVar[int] = SCHEMA
    kind: Literal["bench"] = Field(description="kind of document")
    started_utc: str = Field(description="when it began")
    seconds: float = Field(ge=0.0, description="how long it took")
    command: str = Field(description="the command that measured it")
    machine: Table = Field(description="operating system and processor")
    load_average: tuple[Number, ...] = Field(
        description="mean number of busy processes in the minute before, and in the minute before the end"
    )
    yardstick_flags: str | None = Field(
        default=None, description="flags of the C compiler for the yardstick, in files of earlier versions"
    )
    provenance: Table = Field(description="versions, and the commit of drivegate's sources")
    valid: bool = Field(description="whether every result was right")
    rows: tuple[BenchRow, ...] = Field(description="what was measured")
    compared: Table | None = Field(default=None, description="the earlier document")


def load_now() -> float | None:
    """Return how busy the machine is."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else None


def bench_document(
    rows: Sequence[BenchRow],
    *,
    command: str,
    started: datetime,
    seconds: float,
    load_average: tuple[float | None, float | None],
) -> Table:
    """Put measured rows together with where and when they were measured."""
    document: Table = {
        "schema": SCHEMA,
        "kind": "bench",
        "started_utc": started.isoformat(timespec="seconds"),
        "seconds": round(seconds, 3),
        "command": command,
        "machine": machine(),
        "load_average": list(load_average),
        "provenance": provenance(),
        "valid": all(row.valid is not False for row in rows),
        "rows": [row.model_dump(exclude={"earlier", "times_as_good"}) for row in rows],
        "compared": None,
    }
    return document


def compared_with(document: Table, earlier: BenchDocument, file: Path) -> Table:
    """Set each number beside that of an earlier document."""
    before = {(row.name, row.setting): row.value for row in earlier.rows if row.valid}
    rows = []
    for row in document["rows"]:
        old = before.get((row["name"], row["setting"]))
        rows.append(row | {"earlier": old, "times_as_good": _times_as_good(row, old)})
    compared = {
        "file": str(file),
        "started_utc": earlier.started_utc,
        "commit": earlier.provenance.get("commit"),
        "same_machine": earlier.machine == document["machine"],
        "rows": sum(row["times_as_good"] is not None for row in rows),
    }
    return document | {"rows": rows, "compared": compared}


def _times_as_good(row: Table, old: float | None) -> float | None:
    new = row["value"]
    if not new or not old or not row["valid"]:
        return None
    ratio: float = new / old if row["better"] == "more" else old / new
    return ratio


def read_bench(file: Path) -> BenchDocument:
    """Read a saved document."""
    return read_document(file, BenchDocument)


def save_bench(document: Table, file: Path) -> None:
    """Save a document."""
    write_atomically(file, json.dumps(finite(document), indent=2, allow_nan=False) + "\n")
