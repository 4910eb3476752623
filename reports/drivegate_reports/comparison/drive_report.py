"""The page of a comparison of drives, from its document alone."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

from drivegate.contracts.comparison import HELD, POINTS, Column, Figure, Words, name_of
from drivegate.studies.compare.drive_comparison import KIND, SCHEMA
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_reports.comparison.cells import name, sheet_of, written
from drivegate_reports.comparison.drive_curves import drive_figures
from drivegate_reports.comparison.report import (
    ComparisonView,
    PageSection,
    common_facts,
    provenance_rows,
    troubles_of,
)
from drivegate_reports.comparison.sheets import FAILED, held_of, joined
from drivegate_reports.page.page import clean, require_document

REPORT_FILE: Final = "drive-comparison.html"
"""Name of the page in the report's folder."""
_MOST_SENTENCES: Final = 6
_CANDIDATE: Final = name_of("candidate")
_DRIVE: Final = name_of("drive")
_SPEED: Final = Figure("speed_rpm", "speed", "rpm", 0)
_EFFICIENCY: Final = Figure("efficiency_percent", "efficiency", "%")
_CURRENT: Final = (
    Figure("current_sum_a", "Σ|i|", "A", None),
    Figure("current_sum_pu", "Σ|i|", "pu", 3),
)
_POWER: Final = (
    Figure("input_power_w", "input power", "W", None),
    Figure("input_power_pu", "input power", "pu", 4),
)
_LOSSES: Final = (Figure("losses_w", "losses", "W", None), Figure("losses_pu", "losses", "pu", 4))
SUMMARY: Final[tuple[Column, ...]] = (
    _CANDIDATE,
    _DRIVE,
    Words(
        "status", lambda row: str(row["status"]), lambda row: "" if row["status"] == "compared" else "fail"
    ),
    FAILED,
    held_of("points"),
    Figure("points_shared", "over points", digits=0),
    _EFFICIENCY,
    *_POWER,
    *_LOSSES,
    *_CURRENT,
    Figure("ripple_full_load_percent", "worst ripple at full load", "%", 1),
    Figure("rated_power_held_up_to_rpm", "rated power held up to", "rpm", 0),
    Figure("rated_power_held_up_to_pu", "held up to", "pu"),
)
"""Columns of the drives side by side for each candidate."""
DRIVES: Final[tuple[Column, ...]] = (
    _DRIVE,
    Figure("phases", "phases", digits=0),
    Figure("supply_voltage_v", "supply", "± V, or link", None),
    Figure("rated_power_w", "rated power", "W", None),
    Figure("current_limit_a", "current limit", "A", None),
    Figure("base_speed_rpm", "base speed", "rpm", 0),
    Figure("base_torque_nm", "rated torque there", "N·m", None),
    Figure("base_current_sum_a", "phases × limit", "A", None),
    Figure("highest_speed_rpm", "highest speed", "rpm", 0),
    Figure("overspeed_rpm", "overspeed", "rpm", 0),
    Figure("constant_power_up_to_rpm", "rated power up to", "rpm", 0),
    Figure("constant_power_up_to_pu", "over base speed", "pu"),
    Words("hash", lambda row: str(row["hash"])[:8]),
)
"""Columns of the drives, their bases, and how far they reach rated power."""
_POINTS: Final[tuple[Column, ...]] = (
    _CANDIDATE,
    _DRIVE,
    _SPEED,
    Figure("speed_pu", "speed", "pu"),
    Figure("load_percent", "of rated power", "%", 0),
    Figure("torque_nm", "load", "N·m", None),
    Figure("torque_pu", "load", "pu", 3),
    HELD,
    Figure("ripple_percent", "ripple", "%", 1),
    *_CURRENT,
    *_POWER,
    _EFFICIENCY,
    *_LOSSES,
    Figure("electrical_losses_pu", "electrical", "pu", 4),
    Figure("mechanical_losses_pu", "mechanical", "pu", 4),
)


def write(document: Mapping[str, Any], folder: Path) -> Path:
    """Write the report of a comparison of drives."""
    path = folder / REPORT_FILE
    write_atomically(path, page(document))
    return path


def page(document: Mapping[str, Any]) -> str:
    """Make the page."""
    from drivegate_reports.page.page import page_text

    return page_text("comparison.html.j2", view=drive_view_of(document))


def drive_view_of(document: Mapping[str, Any]) -> ComparisonView:
    """Prepare the document of a comparison of drives for the page."""
    require_document(document, KIND, SCHEMA, "the comparison of drives")
    drives = [name(entry["label"]) for entry in document["drives"]]
    return ComparisonView(
        subject=f"of {len(drives)} drives",
        headline=f"{joined(drives)} under the same controllers",
        sentences=tuple(_sentences(document))[:_MOST_SENTENCES],
        note=clean(document["bases"]),
        sections=tuple(_sections(document, drives)),
        troubles=tuple(
            trouble
            for drive, part in zip(drives, document["parts"], strict=True)
            for trouble in troubles_of(part, f" on {drive}")
        ),
        method=(
            "Every candidate gets each drive's own nameplate, and runs the same plan on each: speeds are the same "
            "shares of the drive's range, loads the same shares of its rated power, times multiples of its time "
            "constants.",
            clean(document["losses"]),
            "Efficiency is the load's mean power over the mean input power. A mean is over the points that a "
            "candidate holds on every drive, so that all drives do the same.",
            "Ripple is peak to peak over mean, of the worst electrical period of the last second.",
        ),
        facts=(
            ("drives", str(len(drives))),
            ("candidates", str(len(document["candidates"]))),
            *common_facts(document),
        ),
        provenance=provenance_rows(document),
        file="drive-comparison.json",
    )


def _sections(document: Mapping[str, Any], drives: list[str]) -> Iterator[PageSection]:
    tables = document["tables"]
    summary = (
        "Means and ripple over the operating points that the candidate holds on every drive. Rated power is held up to "
        "the last of the speeds that were run, without a gap. Full load is rated power, or 90 % of it for controllers "
        "of duty ratios."
    )
    bases = (
        "One per unit is base speed, rated torque there, phases × limit and rated power. Rated power up to: the speed "
        "up to which the drive reaches it at the current limit without a gap, overspeed at most, whatever the "
        "controller."
    )
    yield PageSection(
        name="summary",
        title="Side by side",
        sheet=sheet_of("summary", summary, SUMMARY, tables["summary"]),
    )
    yield PageSection(
        name="drives",
        title="The drives",
        link="Drives",
        sheet=sheet_of("drives", bases, DRIVES, tables["drives"]),
    )
    yield PageSection(
        name="speed", title="Over speed, at full load", link="Over speed", figures=drive_figures(document)
    )
    yield PageSection(
        name="points",
        title="Every operating point",
        link="Operating points",
        sheet=sheet_of(POINTS, "Ideal sensors, after the time to converge.", _POINTS, tables[POINTS]),
        folded="All candidates, drives, speeds and loads",
    )
    yield PageSection(
        name="each",
        title="Each drive by itself",
        link="Each drive",
        words=("What is known of the candidates on each drive alone:",),
        links=tuple(
            (drive, f"{entry['folder']}/comparison.html")
            for drive, entry in zip(drives, document["drives"], strict=True)
        ),
    )


def _sentences(document: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    for entry in document["candidates"]:
        rows = [row for row in document["tables"]["summary"] if row["candidate"] == entry["label"]]
        shared, words = rows[0]["points_shared"], "holds no operating point on every drive"
        if shared:
            words = (
                f"over the {shared} operating points that it holds on every drive: losses (pu) "
                f"{_spread(rows, 'losses_pu', 4)}; Σ|i| (pu) {_spread(rows, 'current_sum_pu', 3)}"
            )
            ripple = _spread(rows, "ripple_full_load_percent", 1)
            words += f"; ripple at full load (%) {ripple}" if ripple else ""
        yield name(entry["label"]), f"{words}."


def _spread(rows: list[Mapping[str, Any]], key: str, digits: int) -> str:
    """List the drives from the least of a quantity to the greatest."""
    known = sorted((row for row in rows if row[key] is not None), key=lambda row: float(row[key]))
    return ", ".join(f"{name(row['drive'])} {written(row[key], digits)}" for row in known)
