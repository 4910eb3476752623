"""The document of a comparison of drives: the same candidates on each, with the comparison on every drive as a part."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

from drivegate.drives.abilities import ability_of
from drivegate.studies.compare.compared_drive import ComparedDrive
from drivegate.studies.compare.document import sealed
from drivegate.studies.compare.drive_tables import (
    BASES_IN_WORDS,
    LOSSES_IN_WORDS,
    bases_of,
    drive_rows,
    operating_rows,
    power_rows,
    summary_rows,
)

SCHEMA: Final = 1
"""Version of the document."""
KIND: Final = "drive-comparison"
"""Kind of the document."""


def drive_comparison_document(
    labels: Sequence[str], made: Sequence[ComparedDrive], *, timing: Mapping[str, Any]
) -> dict[str, Any]:
    """Return a comparison of drives as plain data: bases, candidates, tables, and the comparison on each drive.

    Each drive has a different label; `timing` is left out of the content hash.
    """
    points = operating_rows(labels, made)
    drives = [one.request.drive for one in made]
    ranges = [ability_of(drive).constant_power(drive) for drive in drives]
    parts = [one.document for one in made if one.document is not None]
    content: dict[str, Any] = {
        "schema": SCHEMA,
        "kind": KIND,
        "effort": made[0].request.effort,
        "seed": made[0].request.seed,
        "bases": BASES_IN_WORDS,
        "losses": LOSSES_IN_WORDS,
        "drives": [
            {
                "label": label,
                **drive.identity(),
                "per_unit": bases_of(drive).document(),
                # A name is anybody's text.
                "folder": f"drive-{number}",
            }
            for number, (label, drive) in enumerate(zip(labels, drives, strict=True), 1)
        ],
        "candidates": [
            {key: entry[key] for key in ("label", "specification", "kind", "hash")}
            for entry in parts[0]["candidates"]
        ],
        "tables": {
            "summary": summary_rows(labels, made, points),
            "drives": drive_rows(labels, drives, ranges),
            "operating_points": points,
            "greatest_power": power_rows(labels, drives, ranges),
        },
        "parts": parts,
    }
    return sealed(content, _hashed, timing)


def _hashed(content: dict[str, Any]) -> dict[str, Any]:
    """Represent each part by its own hash, which leaves out what differs from run to run."""
    return {**content, "parts": [part["provenance"]["content_hash"] for part in content["parts"]]}
