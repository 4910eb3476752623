"""From the document of a comparison of drives to what its page says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from drivegate.studies.compare.drive_comparison import KIND, SCHEMA
from drivegate_reports.comparison.cells import Sheet, name
from drivegate_reports.comparison.drive_sheets import drive_point_sheet, drive_sheet, spread, summary_sheet
from drivegate_reports.page.printable import clean
from drivegate_reports.page.readable import require_document

_MOST_SENTENCES: Final = 6


@dataclass(frozen=True)
class DriveView:
    """A comparison of drives as the page shows it."""

    headline: str
    """What is compared."""
    sentences: tuple[tuple[str, str], ...]
    """A candidate, and what is to be said of the drives under it."""
    bases: str
    losses: str
    """What per unit is, and how losses are split."""
    summary: Sheet
    drives: Sheet
    points: Sheet
    """Tables."""
    parts: tuple[tuple[str, str], ...]
    """Each drive, and the page of its own."""
    troubles: tuple[tuple[str, str, str, str], ...]
    """Who was refused or failed, where, how, and what happened."""
    facts: tuple[tuple[str, str], ...]
    provenance: tuple[tuple[str, str], ...]
    """Names and values."""


def drive_view_of(document: Mapping[str, Any]) -> DriveView:
    """Prepare the document of a comparison of drives for the page."""
    require_document(document, KIND, SCHEMA, "the comparison of drives")
    drives = [name(entry["label"]) for entry in document["drives"]]
    return DriveView(
        headline=f"{', '.join(drives[:-1])} and {drives[-1]} under the same controllers",
        sentences=tuple(_sentences(document))[:_MOST_SENTENCES],
        bases=clean(document["bases"]),
        losses=clean(document["losses"]),
        summary=summary_sheet(document),
        drives=drive_sheet(document),
        points=drive_point_sheet(document),
        parts=tuple(
            (label, f"{entry['folder']}/comparison.html")
            for label, entry in zip(drives, document["drives"], strict=True)
        ),
        troubles=tuple(_troubles(document)),
        facts=(
            ("effort", clean(document["effort"])),
            ("seed", str(document["seed"])),
            ("drives", str(len(drives))),
            ("candidates", str(len(document["candidates"]))),
            ("date", clean(document["timing"].get("started_utc", "–"))),
        ),
        provenance=_provenance(document),
    )


def _sentences(document: Mapping[str, Any]) -> list[tuple[str, str]]:
    said = []
    for entry in document["candidates"]:
        rows = [row for row in document["tables"]["summary"] if row["candidate"] == entry["label"]]
        shared = rows[0]["points_shared"]
        if not shared:
            said.append((name(entry["label"]), "holds no operating point on every drive."))
            continue
        words = (
            f"over the {shared} operating points that it holds on every drive: losses (pu) "
            f"{spread(rows, 'losses_pu', 4)}; Σ|i| (pu) {spread(rows, 'current_sum_pu', 3)}"
        )
        ripple = spread(rows, "ripple_full_load_percent", 1)
        said.append(
            (name(entry["label"]), f"{words}{f'; ripple at full load (%) {ripple}' if ripple else ''}.")
        )
    return said


def _troubles(document: Mapping[str, Any]) -> list[tuple[str, str, str, str]]:
    troubles = []
    for entry, part in zip(document["drives"], document["parts"], strict=True):
        drive = name(entry["label"])
        for candidate in part["candidates"]:
            label = name(candidate["label"])
            if candidate["refusal"] is not None:
                troubles.append((label, drive, "refused", clean(candidate["refusal"])))
            troubles += [
                (label, drive, clean(fault["kind"]), clean(fault["message"])) for fault in candidate["faults"]
            ]
    return troubles


def _provenance(document: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    given = document["provenance"]
    packages = ", ".join(f"{key} {value}" for key, value in given.get("packages", {}).items())
    rows = [(key, value) for key, value in given.items() if key != "packages"]
    drives = [(f"{entry['label']}, {entry['kind']}", entry["hash"]) for entry in document["drives"]]
    candidates = [
        (f"{entry['label']}, {entry['kind']}", entry["hash"])
        for entry in document["candidates"]
        if entry["hash"]
    ]
    return tuple(
        (name(key), clean(value)) for key, value in (*rows, ("packages", packages), *drives, *candidates)
    )
