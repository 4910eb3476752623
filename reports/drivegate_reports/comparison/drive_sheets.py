"""The tables of the page that compares drives."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from drivegate_reports.comparison.cells import Cell, Sheet, absolute, figure, name, written
from drivegate_reports.page.printable import clean

Row = Mapping[str, Any]


def summary_sheet(document: Row) -> Sheet:
    """Show the drives side by side for each candidate."""
    rows = tuple(
        (
            Cell(name(row["candidate"])),
            Cell(name(row["drive"])),
            Cell(clean(row["status"]), "" if row["status"] == "compared" else "fail"),
            Cell(
                "–" if row["required_failed"] is None else str(row["required_failed"]),
                "fail" if row["required_failed"] else "",
                is_number=True,
            ),
            Cell(
                f"{row['points_held']} of {row['points']}",
                "fail" if row["points_held"] < row["points"] else "",
                is_number=True,
            ),
            Cell(str(row["points_shared"]), is_number=True),
            figure(row["efficiency_percent"], 2),
            figure(row["input_power_pu"], 4),
            absolute(row["input_power_w"]),
            figure(row["losses_pu"], 4),
            absolute(row["losses_w"]),
            figure(row["current_sum_pu"], 3),
            absolute(row["current_sum_a"]),
            figure(row["ripple_full_load_percent"], 1),
            figure(row["rated_power_held_up_to_rpm"], 0),
            figure(row["rated_power_held_up_to_pu"], 2),
        )
        for row in document["tables"]["summary"]
    )
    heads = (
        "candidate",
        "drive",
        "status",
        "required checks failed",
        "operating points held",
        "over points",
        "efficiency (%)",
        "input power (pu)",
        "input power (W)",
        "losses (pu)",
        "losses (W)",
        "Σ|i| (pu)",
        "Σ|i| (A)",
        "worst ripple at full load (%)",
        "rated power held up to (rpm)",
        "held up to (pu)",
    )
    caption = (
        "Means and ripple over the operating points that the candidate holds on every drive. Rated power is held up to "
        "the last of the speeds that were run, without a gap. Full load is rated power, or 90 % of it for controllers "
        "of duty ratios."
    )
    return Sheet("summary", caption, heads, rows)


def drive_sheet(document: Row) -> Sheet:
    """Show the drives, their bases, and how far they keep rated power."""
    rows = tuple(
        (
            Cell(name(row["drive"])),
            Cell(str(row["phases"]), is_number=True),
            absolute(row["supply_voltage_v"]),
            absolute(row["rated_power_w"]),
            absolute(row["current_limit_a"]),
            figure(row["base_speed_rpm"], 0),
            absolute(row["base_torque_nm"]),
            absolute(row["base_current_sum_a"]),
            figure(row["highest_speed_rpm"], 0),
            figure(row["overspeed_rpm"], 0),
            figure(row["constant_power_up_to_rpm"], 0),
            figure(row["constant_power_up_to_pu"], 2),
            Cell(clean(row["hash"])[:8]),
        )
        for row in document["tables"]["drives"]
    )
    heads = (
        "drive",
        "phases",
        "supply (± V, or link)",
        "rated power (W)",
        "current limit (A)",
        "base speed (rpm)",
        "rated torque there (N·m)",
        "phases × limit (A)",
        "highest speed (rpm)",
        "overspeed (rpm)",
        "rated power up to (rpm)",
        "over base speed (pu)",
        "hash",
    )
    caption = (
        "One per unit is base speed, rated torque there, phases × limit and rated power. Rated power up to: the speed "
        "to which the drive gives it at the current limit without a gap, overspeed at most, whatever the controller."
    )
    return Sheet("drives", caption, heads, rows)


def drive_point_sheet(document: Row) -> Sheet:
    """Show every candidate on every drive at every operating point."""
    rows = tuple(
        (
            Cell(name(row["candidate"])),
            Cell(name(row["drive"])),
            figure(row["speed_rpm"], 0),
            figure(row["speed_pu"], 2),
            figure(row["load_percent"], 0),
            absolute(row["torque_nm"]),
            figure(row["torque_pu"], 3),
            Cell("yes" if row["held"] else "no", "" if row["held"] else "fail"),
            figure(row["ripple_percent"], 1),
            absolute(row["current_sum_a"]),
            figure(row["current_sum_pu"], 3),
            absolute(row["input_power_w"]),
            figure(row["input_power_pu"], 4),
            figure(row["efficiency_percent"], 2),
            absolute(row["losses_w"]),
            figure(row["losses_pu"], 4),
            figure(row["electrical_losses_pu"], 4),
            figure(row["mechanical_losses_pu"], 4),
        )
        for row in document["tables"]["operating_points"]
    )
    heads = (
        "candidate",
        "drive",
        "speed (rpm)",
        "speed (pu)",
        "of rated power (%)",
        "load (N·m)",
        "load (pu)",
        "held",
        "ripple (%)",
        "Σ|i| (A)",
        "Σ|i| (pu)",
        "input power (W)",
        "input power (pu)",
        "efficiency (%)",
        "losses (W)",
        "losses (pu)",
        "electrical (pu)",
        "mechanical (pu)",
    )
    return Sheet("operating_points", "Ideal sensors, after the time to converge.", heads, rows)


def spread(rows: list[Row], key: str, digits: int) -> str:
    """List the drives from the least of a quantity to the greatest."""
    known = sorted((row for row in rows if row[key] is not None), key=lambda row: float(row[key]))
    return ", ".join(f"{name(row['drive'])} {written(row[key], digits)}" for row in known)
