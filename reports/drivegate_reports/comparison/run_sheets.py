"""The tables of the comparison page about single runs: operating points, disturbances, drive cycle, checks, times."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from drivegate_reports.comparison.cells import Cell, Sheet, figure, name, written
from drivegate_reports.comparison.curves import change_s
from drivegate_reports.page.printable import clean

Row = Mapping[str, Any]


def point_sheet(document: Row) -> Sheet:
    """Show every candidate at every operating point."""
    rows = tuple(
        (
            Cell(name(row["candidate"])),
            figure(row["speed_rpm"], 0),
            figure(row["torque_nm"], 2),
            figure(row["load_percent"], 0),
            Cell(
                "yes" if row["held"] else f"off by {written(row['speed_error_rpm'], 0)} rpm",
                "" if row["held"] else "fail",
            ),
            figure(row["input_power_w"], 1),
            figure(row["current_sum_a"], 2),
            figure(row["gap_power_w"], 1, signed=True),
            figure(row["gap_current_percent"], 1, signed=True),
            figure(row["ripple_percent"], 1),
            figure(row["advance_deg"], 1),
            figure(row["above_edge_deg"], 1, signed=True),
            figure(row["converged_after_s"], 2),
        )
        for row in document["tables"]["operating_points"]
    )
    heads = (
        "candidate",
        "speed (rpm)",
        "load (N·m)",
        "of 1.5 kW (%)".replace("1.5", f"{document['drive']['rated_power_w'] / 1000:g}"),
        "held",
        "input power (W)",
        "Σ|i| (A)",
        "power above best possible (W)",
        "Σ|i| above best possible (%)",
        "ripple (%)",
        "angle (°)",
        "above feasible edge (°)",
        "converged after (s)",
    )
    return Sheet(
        "operating_points",
        f"Means over what follows the time to converge, in {written(change_s(document), 0)} s at each point, ideal "
        "sensors.",
        heads,
        rows,
    )


def disturbance_sheet(document: Row) -> Sheet:
    """Show how candidates get over disturbances."""
    given = document["tables"]["disturbances"]
    order = list(dict.fromkeys(row["disturbance"] for row in given))
    rows = tuple(
        (
            Cell(clean(row["disturbance"])),
            Cell(name(row["candidate"])),
            figure(row["worst_error_rpm"], 1),
            _recovery(row),
            figure(row["input_power_w"], 1),
            figure(row["current_sum_a"], 2),
        )
        for row in sorted(given, key=lambda row: order.index(row["disturbance"]))
    )
    heads = (
        "disturbance",
        "candidate",
        "worst speed error (rpm)",
        "held again after (s)",
        "input power in the end (W)",
        "Σ|i| in the end (A)",
    )
    caption = (
        "Time from the end of the disturbance until the speed stays within k1, and means of what follows the time "
        "to converge. "
        "A step of the speed reference is a speed error at once."
    )
    return Sheet("disturbances", caption, heads, rows)


def _recovery(row: Row) -> Cell:
    if row["recovery_s"] is not None:
        return figure(row["recovery_s"], 2)
    return Cell("not held again" if row["held_before"] else "not held before", "fail", sort="1e9")


def cycle_sheet(document: Row) -> Sheet:
    """Show what the drive cycle cost each candidate."""
    runs = document["tables"]["drive_cycle"]
    rows = tuple(
        (
            Cell(name(row["candidate"])),
            _follows(row),
            figure(row["energy_wh"], 2),
            figure(row["distance_km"], 3),
            figure(row["energy_wh_per_km"], 2),
            _noisy_mean(
                [run for run in runs if run["candidate"] == row["candidate"] and run["seed"] is not None]
            ),
            figure(row["energy_accelerating_wh"], 2),
            figure(row["energy_cruising_wh"], 2),
            figure(row["energy_slowing_wh"], 2),
            figure(row["energy_standing_wh"], 2),
            figure(row["current_sum_mean_a"], 2),
            figure(row["tracking_error_rms_km_h"], 3),
            figure(row["tracking_error_worst_km_h"], 2, signed=True),
        )
        for row in runs
        if row["seed"] is None
    )
    heads = (
        "candidate",
        "follows the cycle",
        "energy (Wh)",
        "distance (km)",
        "Wh/km",
        "Wh/km, noisy sensors",
        "accelerating (Wh)",
        "cruising (Wh)",
        "slowing (Wh)",
        "standing (Wh)",
        "mean Σ|i| (A)",
        "speed error, rms (km/h)",
        "worst (km/h)",
    )
    caption = (
        f"With ideal sensors, and the mean with noisy ones. Who is {document['cycle']['tolerance_km_h']:g} km/h off "
        "has not driven the cycle, so that its energy is not comparable."
    )
    return Sheet("drive_cycle", caption, heads, rows)


def _follows(row: Row) -> Cell:
    outside = written(row["outside_tolerance_s"], 1)
    return Cell("yes") if row["follows"] else Cell(f"no, {outside} s outside", "fail")


def _noisy_mean(runs: Sequence[Row]) -> Cell:
    good = [run["energy_wh_per_km"] for run in runs if run["follows"]]
    if not good:
        return Cell("does not follow" if runs else "–", "fail" if runs else "", is_number=True, sort="1e9")
    lost = f" ({len(good)} of {len(runs)})" if len(good) < len(runs) else ""
    return Cell(written(sum(good) / len(good), 2) + lost, is_number=True)


def check_sheet(document: Row) -> Sheet | None:
    """Show margin and verdict of every check side by side."""
    checks = document["tables"]["checks"]
    if not checks:
        return None
    labels = list(dict.fromkeys(row["candidate"] for row in checks))
    of = {(row["check"], row["candidate"]): row for row in checks}
    rows = []
    for check in dict.fromkeys(row["check"] for row in checks):
        row = next(row for row in checks if row["check"] == check)
        cells = (_check_cell(of.get((check, label))) for label in labels)
        rows.append((Cell(clean(check)), Cell(clean(row["level"])), *cells, Cell(clean(row["requirement"]))))
    caption = (
        f"Least margin over all runs at {document['checks_effort']} effort: distance from the limit over the limit, "
        "negative where the requirement is not met."
    )
    return Sheet("checks", caption, ("check", "level", *map(name, labels), "requirement"), tuple(rows))


def _check_cell(row: Row | None) -> Cell:
    if row is None:
        return Cell("–")
    if row["margin"] is None:
        return Cell(clean(row["verdict"]))
    tone = {"pass": "pass", "fail": "fail" if row["level"] == "required" else "caution"}.get(
        row["verdict"], ""
    )
    return Cell(
        f"{row['verdict']} {written(row['margin'], 3, signed=True)}", tone, sort=f"{row['margin']:.6f}"
    )


def timing_sheet(document: Row) -> Sheet | None:
    """Show time and size of a controller's step."""
    kinds = {entry["label"]: entry["kind"] for entry in document["candidates"]}
    rows = tuple(
        (
            Cell(name(row["candidate"])),
            Cell(clean(kinds.get(row["candidate"]) or "–")),
            figure(row["step_us"], 3),
            figure(row["share_of_period_percent"], 3),
            Cell("–" if row["state_bytes"] is None else str(row["state_bytes"]), is_number=True),
        )
        for row in document["timing"]["steps"]
    )
    heads = ("candidate", "kind", "time of a step (µs)", "of the control period (%)", "state (bytes)")
    caption = "Measured on the machine that compared; no part of the ranking or of the content hash."
    return Sheet("timing", caption, heads, rows) if rows else None
