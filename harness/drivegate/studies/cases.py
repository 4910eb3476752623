"""The scenarios, operating points, sweeps, drive cycles and drives that are included, as a document."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from drivegate.output.console import plain, table
from drivegate_cases.drive.drive_document import DriveDocument, drive_names, load_drive
from drivegate_cases.scenario.drive_cycle import cycle_names, load_drive_cycle
from drivegate_cases.scenario.operating_point import (
    load_operating_point,
    load_power_sweep,
    operating_point_names,
    power_sweep_names,
)
from drivegate_cases.scenario.scenario import load_scenario, scenario_names

if TYPE_CHECKING:
    from rich.console import Console

SCHEMA: Final = 1


def cases_document() -> dict[str, Any]:
    """List everything that is included."""
    return {
        "schema": SCHEMA,
        "scenarios": _scenarios(),
        "operating_points": _operating_points(),
        "sweeps": _sweeps(),
        "drive_cycles": _drive_cycles(),
        "drives": _drives(),
    }


def _scenarios() -> list[dict[str, Any]]:
    return [
        {
            "name": name,
            "description": scenario.description,
            "drive": scenario.drive.name,
            "duration_s": scenario.duration_s,
        }
        for name in scenario_names()
        for scenario in [load_scenario(name)]
    ]


def _operating_points() -> list[dict[str, Any]]:
    return [
        {
            "name": name,
            "description": point.description,
            "source": point.source,
            "speed_rpm": point.speed_rpm,
            "torque_nm": point.torque_nm,
            "advance_deg": point.advance_deg,
        }
        for name in operating_point_names()
        for point in [load_operating_point(name)]
    ]


def _sweeps() -> list[dict[str, Any]]:
    return [
        {
            "name": name,
            "description": sweep.description,
            "source": sweep.source,
            "speeds_rpm": list(sweep.speeds_rpm),
            "power_w": sweep.power_w,
        }
        for name in power_sweep_names()
        for sweep in [load_power_sweep(name)]
    ]


def _drive_cycles() -> list[dict[str, Any]]:
    return [
        {
            "name": name,
            "description": cycle.description,
            "source": cycle.source,
            "duration_s": cycle.duration_s,
            "distance_m": cycle.distance_m,
        }
        for name in cycle_names()
        for cycle in [load_drive_cycle(name)]
    ]


def _supply(drive: DriveDocument) -> str:
    """Return the voltage of a drive's supply; one without a tap is no two halves to its user."""
    half = drive.inverter.supply_voltage_v
    return f"2 × {half:g} V" if drive.has_split_supply else f"{2.0 * half:g} V"


def _drives() -> list[dict[str, Any]]:
    return [
        {
            "name": name,
            "description": f"{drive.machine.phases} phases, {2 * drive.machine.pole_pairs} poles, "
            f"{drive.rating.rated_power_w:g} W, "
            f"{drive.rating.base_speed_rpm:g} rpm, {_supply(drive)}",
        }
        for name in drive_names()
        for drive in [load_drive(name)]
    ]


def show_cases(console: Console, document: dict[str, Any]) -> None:
    """Print one table for each kind."""
    for key, heading in (
        ("scenarios", "scenario"),
        ("operating_points", "operating point"),
        ("sweeps", "sweep"),
        ("drive_cycles", "drive cycle"),
        ("drives", "drive"),
    ):
        listed = table(heading, "description")
        for row in document[key]:
            listed.add_row(plain(row["name"]), plain(row["description"]))
        console.print(listed)
    console.print(
        plain(
            "next: drivegate simulate reference --case NAME runs a scenario, --drive NAME takes a drive, "
            "drivegate compare A B --cycle NAME drives a cycle",
            "dim",
        )
    )
