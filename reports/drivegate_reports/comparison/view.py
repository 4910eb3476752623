"""From the comparison document to what its page says: the decision in sentences, then tables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from drivegate.studies.compare.document import KIND, SCHEMA
from drivegate_cases.documents.wording import counted
from drivegate_reports.comparison.cells import Sheet, name, written
from drivegate_reports.comparison.curves import held_rpm
from drivegate_reports.comparison.run_sheets import (
    check_sheet,
    cycle_sheet,
    disturbance_sheet,
    point_sheet,
    timing_sheet,
)
from drivegate_reports.comparison.sheets import difference_sheet, ranking_sheet, region_sheet
from drivegate_reports.page.printable import clean
from drivegate_reports.page.readable import require_document

_MOST_SENTENCES: Final = 6
_UNTOLD_SENSORS: Final = "the sensors of the drive"
"""Of documents of earlier versions, which do not tell them."""
_LONGEST_BLOCK: Final = 4_000


@dataclass(frozen=True)
class Trouble:
    """A candidate that could not be compared."""

    candidate: str
    """Its name."""
    what: str
    """``refused``, or the kind of fault."""
    message: str
    """What happened."""
    detail: str
    """Traceback; empty where there is none."""


@dataclass(frozen=True)
class ComparisonView:
    """A comparison as the page shows it."""

    candidates: tuple[str, ...]
    """Names."""
    headline: str
    """Who is first."""
    sentences: tuple[tuple[str, str], ...]
    """The decision: a name and what is to be said of it, best first."""
    rule: str
    method: str
    """How candidates are ranked, and how differences are judged."""
    facts: tuple[tuple[str, str], ...]
    """Names and values about the comparison."""
    troubles: tuple[Trouble, ...]
    """Candidates that were refused or failed."""
    ranking: Sheet
    regions: Sheet
    differences: Sheet
    points: Sheet
    disturbances: Sheet
    cycle: Sheet
    """Tables."""
    checks: Sheet | None
    timing: Sheet | None
    """Tables that may be missing."""
    sensors: str
    """The sensors of the noisy runs."""
    held_rpm: str
    """k1, the speed error within which a speed counts as held."""
    vehicle: str
    """The vehicle of the drive cycle, in a sentence."""
    cycle_words: str
    """The drive cycle, in a sentence."""
    provenance: tuple[tuple[str, str], ...]
    """Names and values."""


def view_of(document: Mapping[str, Any]) -> ComparisonView:
    """Prepare a comparison document for the page."""
    require_document(document, KIND, SCHEMA, "the comparison")
    return ComparisonView(
        candidates=tuple(name(entry["label"]) for entry in document["candidates"]),
        headline=_headline(document),
        sentences=tuple(_sentences(document))[:_MOST_SENTENCES],
        rule=clean(document["rule"]),
        method=clean(document["method"]),
        facts=_facts(document),
        troubles=tuple(troubles_of(document)),
        ranking=ranking_sheet(document),
        regions=region_sheet(document),
        differences=difference_sheet(document),
        points=point_sheet(document),
        disturbances=disturbance_sheet(document),
        cycle=cycle_sheet(document),
        checks=check_sheet(document),
        timing=timing_sheet(document),
        sensors=clean(document["drive"].get("sensors", _UNTOLD_SENSORS)),
        held_rpm=f"{held_rpm(document):g}",
        vehicle=_vehicle(document),
        cycle_words=_cycle(document),
        provenance=provenance_rows(document),
    )


def _joined(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _headline(document: Mapping[str, Any]) -> str:
    first = [name(row["candidate"]) for row in document["tables"]["ranking"] if row["rank"] == 1]
    if not first:
        return "No candidate could be compared"
    if len(first) == 1:
        return f"{first[0]} ranks first"
    return f"{_joined(first)} share the first place"


def _sentences(document: Mapping[str, Any]) -> list[tuple[str, str]]:
    ranked = [row for row in document["tables"]["ranking"] if row["rank"] is not None]
    if not ranked:
        return []
    first, *others = ranked
    said = [(name(first["candidate"]), _standing(first))]
    return said + [(name(row["candidate"]), _against(document, first, row)) for row in others]


def _standing(row: Mapping[str, Any]) -> str:
    failed, all_points = row["required_failed"], row["points_feasible"]
    parts = []
    if failed is not None:
        parts.append(
            f"fails {counted(failed, 'required check')}" if failed else "passes every required check"
        )
    held = "all" if row["points_held"] == all_points else f"{row['points_held']} of"
    parts.append(f"holds {held} {all_points} operating points")
    if row["gap_power_w"] is not None:
        parts.append(
            f"takes {written(row['gap_power_w'], 1)} W more than the best possible angle would, in the mean"
        )
    return f"{_joined(parts)}."


def _against(document: Mapping[str, Any], first: Mapping[str, Any], row: Mapping[str, Any]) -> str:
    watts, amperes, shared = row["power_above_first_w"], row["current_above_first_a"], row["points_shared"]
    if watts is None:
        said = f"holds no operating point that {name(first['candidate'])} holds"
    else:
        power = _more(watts, row["input_power_w"], ("W", "input power"), 1)
        current = _more(amperes, row["current_sum_a"], ("A", "Σ|i|"), 2)
        said = f"takes {power} and {current} over the {shared} points that both hold"
    lost = row["points_feasible"] - row["points_held"]
    if lost:
        said += f", but loses {lost} of {row['points_feasible']} points"
    if row["required_failed"]:
        said += f", and fails {counted(row['required_failed'], 'required check')}"
    sure = _certainty(document, first["candidate"], row["candidate"])
    return said + (f"; {sure}." if sure else ".")


def _more(change: float, level: float, what: tuple[str, str], digits: int) -> str:
    """State a change against a level before it, with its share."""
    unit, quantity = what
    before = level - change
    share = f" ({written(100.0 * change / before, 1, signed=True)} %)" if before else ""
    if round(abs(change), digits) == 0.0:
        return f"as much {quantity}"
    return f"{written(abs(change), digits)} {unit} {'more' if change > 0 else 'less'} {quantity}{share}"


def _certainty(document: Mapping[str, Any], first: str, second: str) -> str:
    for row in document["tables"]["differences"]:
        if row["where"].startswith("drawn") and row["quantity"] == "input_power_w":
            if (row["first"], row["second"]) != (first, second) or row["low"] is None:
                continue
            watts = f"{written(-row['high'], 1, signed=True)} to {written(-row['low'], 1, signed=True)} W"
            where = f"over {row['pairs']} drawn plants with noise that both hold"
            if row["verdict"] == "no real difference":
                return f"{where} there is no real difference in watts ({watts})"
            return f"{where} the difference is real ({watts})"
    return ""


def _facts(document: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    size = document["size"]
    return (
        ("effort", clean(document["effort"])),
        ("seed", str(document["seed"])),
        ("runs of each candidate", str(size["runs_of_each"])),
        ("operating points", str(len(size["speeds_rpm"]) * len(size["shares"]))),
        ("disturbances", str(size["disturbances"])),
        ("drawn plants", str(size["drawn"])),
        ("drive", clean(document["drive"]["name"])),
        ("date", clean(document["timing"].get("started_utc", "–"))),
    )


def troubles_of(document: Mapping[str, Any]) -> list[Trouble]:
    """List the candidates that could not be compared, and why."""
    troubles = []
    for entry in document["candidates"]:
        if entry["refusal"] is not None:
            troubles.append(Trouble(name(entry["label"]), "refused", clean(entry["refusal"]), ""))
        for fault in entry["faults"]:
            detail = clean(fault["traceback"], _LONGEST_BLOCK)
            troubles.append(
                Trouble(name(entry["label"]), clean(fault["kind"]), clean(fault["message"]), detail)
            )
    return troubles


def _vehicle(document: Mapping[str, Any]) -> str:
    vehicle = document["cycle"]["vehicle"]
    return (
        "a vehicle of the drive's size, at 1.5 kW a light electric scooter with its rider: "
        f"{vehicle['mass_kg']:g} kg, wheels of {vehicle['wheel_radius_m']:g} m radius behind a gear of "
        f"{vehicle['gear_ratio']:g}, rolling resistance "
        f"{vehicle['rolling_resistance']:g}, drag area {vehicle['drag_area_m2']:g} m²"
    )


def _cycle(document: Mapping[str, Any]) -> str:
    cycle = document["cycle"]
    return (
        f"{clean(cycle['name'])}: {clean(cycle['description'])} {cycle['duration_s']:g} s and "
        f"{cycle['distance_km']:.3f} km. Source: {clean(cycle['source'])}."
    ).replace("..", ".")


def provenance_rows(document: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    """List what a comparison was made with."""
    given = document["provenance"]
    packages = ", ".join(f"{key} {value}" for key, value in given.get("packages", {}).items())
    rows = [(key, value) for key, value in given.items() if key != "packages"]
    hashes = [
        (f"{entry['label']}, {entry['kind']}", entry["hash"])
        for entry in document["candidates"]
        if entry["hash"]
    ]
    return tuple((name(key), clean(value)) for key, value in (*rows, ("packages", packages), *hashes))
