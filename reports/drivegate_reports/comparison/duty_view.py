"""From the document of a comparison of controllers of duty ratios to what its page says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from drivegate.studies.compare.duty.document import DUTY_KIND, SCHEMA
from drivegate_cases.documents.wording import counted
from drivegate_reports.comparison.cells import Cell, Sheet, absolute, figure, name, written
from drivegate_reports.comparison.run_sheets import check_sheet
from drivegate_reports.comparison.view import Trouble, provenance_rows, troubles_of
from drivegate_reports.page.printable import clean
from drivegate_reports.page.readable import require_document

Row = Mapping[str, Any]


@dataclass(frozen=True)
class DutyComparisonView:
    """A comparison as the page shows it."""

    candidates: tuple[str, ...]
    """Names."""
    headline: str
    """Who is first."""
    sentences: tuple[tuple[str, str], ...]
    """A name and what is to be said of it, best first."""
    rule: str
    """How candidates are ranked."""
    facts: tuple[tuple[str, str], ...]
    """Names and values about the comparison."""
    troubles: tuple[Trouble, ...]
    """Candidates that were refused or failed."""
    ranking: Sheet
    points: Sheet
    steps: Sheet
    """Tables."""
    checks: Sheet | None
    """Missing where the checks were not made."""
    provenance: tuple[tuple[str, str], ...]
    """Names and values."""


def duty_view_of(document: Mapping[str, Any]) -> DutyComparisonView:
    """Prepare the document for the page."""
    require_document(document, DUTY_KIND, SCHEMA, "the comparison")
    drive = document["drive"]
    return DutyComparisonView(
        candidates=tuple(name(entry["label"]) for entry in document["candidates"]),
        headline=_headline(document),
        sentences=tuple(map(_sentence, document["tables"]["ranking"])),
        rule=clean(document["rule"]),
        facts=(
            ("drive", clean(drive["name"])),
            ("effort", clean(document["effort"])),
            ("runs of each", str(document["size"]["runs_of_each"])),
            *_reference_facts(document),
        ),
        troubles=tuple(troubles_of(document)),
        ranking=_ranking(document),
        points=_points(document),
        steps=_steps(document),
        checks=check_sheet(document),
        provenance=provenance_rows(document),
    )


def _reference_facts(document: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    """Tell what was followed; documents from before there was a choice follow torques."""
    drive = document["drive"]
    if document.get("reference") == "speed":
        return (
            ("reference", "speed, under a constant load"),
            ("held within", f"{written(drive['speed_tolerance_rpm'], 3)} rpm"),
        )
    return (
        ("reference", "torque, at held speeds"),
        ("held within", f"{written(drive['torque_tolerance_nm'], 3)} N·m"),
    )


def _headline(document: Mapping[str, Any]) -> str:
    first = [name(row["candidate"]) for row in document["tables"]["ranking"] if row["rank"] == 1]
    on = f"on {clean(document['drive']['name'])}"
    if not first:
        return f"No candidate could be compared {on}"
    return f"{' and '.join(first)} {'is' if len(first) == 1 else 'are'} first {on}"


def _sentence(row: Row) -> tuple[str, str]:
    parts = [f"holds {row['points_held']} of {counted(row['points'], 'operating point')}"]
    if row["failed_checks"]:
        parts.append(f"fails {clean(row['failed_checks']).replace(' ', ', ')}")
    if row["loss_above_least_percent"] is not None:
        parts.append(
            f"loses {written(row['loss_above_least_percent'], 2)} % more than the least on average, at worst "
            f"{written(row['loss_worst_percent'], 2)} %"
        )
    return name(row["candidate"]), f"{', '.join(parts)}."


def _ranking(document: Mapping[str, Any]) -> Sheet:
    heads = (
        "candidate",
        "required checks failed",
        "operating points held",
        "place",
        "loss above least (%)",
        "current above least (%)",
        "worst ripple (%)",
        "worst overshoot (%)",
        "worst rise (%)",
    )
    rows = []
    for row in document["tables"]["ranking"]:
        failed, held, all_points = row["required_failed"], row["points_held"], row["points"]
        compared = row["rank"] is not None
        rows.append(
            (
                Cell(name(row["candidate"])),
                Cell("–" if failed is None else str(failed), "fail" if failed else "", is_number=True),
                Cell(f"{held} of {all_points}", "fail" if held < all_points else "", is_number=True),
                Cell(str(row["rank"]), is_number=True) if compared else Cell(clean(row["status"]), "fail"),
                figure(row["loss_above_least_percent"], 2),
                figure(row["current_above_least_percent"], 2),
                figure(row["ripple_worst_percent"], 2),
                figure(row["overshoot_worst_percent"], 2),
                figure(row["rise_worst_percent_of_allowed"], 0),
            )
        )
    caption = (
        "How many required checks are failed and how many operating points held; then means and worst values over the "
        "points that a candidate holds, ripple over rated torque, rise time over the longest that is allowed."
    )
    return Sheet("ranking", caption, heads, tuple(rows))


def _points(document: Mapping[str, Any]) -> Sheet:
    heads = (
        "candidate",
        "speed (rpm)",
        "asked (N·m)",
        "torque (N·m)",
        "held",
        "d (A)",
        "q (A)",
        "current above least (%)",
        "input (W)",
        "loss (W)",
        "above least (%)",
        "efficiency (%)",
        "voltage (%)",
        "ripple (%)",
    )
    rows = tuple(
        (
            Cell(name(row["candidate"])),
            absolute(row["speed_rpm"]),
            absolute(row["reference_nm"]),
            absolute(row["torque_nm"]),
            Cell("yes" if row["held"] else "no", "" if row["held"] else "fail"),
            absolute(row["direct_current_a"]),
            absolute(row["quadrature_current_a"]),
            figure(row["current_above_least_percent"], 2),
            absolute(row["input_power_w"]),
            absolute(row["loss_w"]),
            figure(row["loss_above_least_percent"], 2),
            figure(row["efficiency_percent"], 2),
            figure(row["voltage_percent"], 1),
            figure(row["ripple_percent"], 2),
        )
        for row in document["tables"]["operating_points"]
    )
    caption = (
        "Torque asked for, or of the load. Currents and losses of the fundamental beside the least for the same "
        "torque; voltage of the undistorted."
    )
    return Sheet("operating_points", caption, heads, rows)


def _steps(document: Mapping[str, Any]) -> Sheet:
    heads = (
        "candidate",
        "speed (rpm)",
        "from (N·m)",
        "to (N·m)",
        "rise (ms)",
        "allowed (ms)",
        "overshoot (%)",
    )
    rows = tuple(
        (
            Cell(name(row["candidate"])),
            *(absolute(row[key]) for key in ("speed_rpm", "before_nm", "after_nm")),
            figure(row["rise_ms"], 2),
            figure(row["allowed_ms"], 2),
            figure(row["overshoot_percent"], 2),
        )
        for row in document["tables"]["steps"]
    )
    return Sheet("steps", "Steps of the torque reference for which the voltage leaves room.", heads, rows)
