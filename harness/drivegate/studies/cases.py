"""The scenarios, operating points, sweeps, drive cycles and drives that are included, as a document."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, Final

from rich.console import Console

from drivegate.output.console import plain, print_line, table
from drivegate_cases.drive.drive_document import DriveDocument, drive_names, load_drive
from drivegate_cases.scenario.drive_cycle import cycle_names, load_drive_cycle
from drivegate_cases.scenario.operating_point import (
    load_operating_point,
    load_power_sweep,
    operating_point_names,
    power_sweep_names,
)
from drivegate_cases.scenario.scenario import load_scenario, scenario_names

SCHEMA: Final = 1


def cases_document() -> dict[str, Any]:
    point_keys = ("description", "source", "speed_rpm", "torque_nm", "advance_deg")
    sweep_keys = ("description", "source", "speeds_rpm", "power_w")
    cycle_keys = ("description", "source", "duration_s", "distance_m")
    return {
        "schema": SCHEMA,
        "scenarios": [
            {
                "name": name,
                "description": scenario.description,
                "drive": scenario.drive.name,
                "duration_s": scenario.duration_s,
            }
            for name in scenario_names()
            for scenario in [load_scenario(name)]
        ],
        "operating_points": _listed(operating_point_names(), load_operating_point, point_keys),
        "sweeps": _listed(power_sweep_names(), load_power_sweep, sweep_keys),
        "drive_cycles": _listed(cycle_names(), load_drive_cycle, cycle_keys),
        "drives": [{"name": name, "description": _in_short(load_drive(name))} for name in drive_names()],
    }


def _listed(names: Iterable[str], load: Callable[[str], object], keys: Sequence[str]) -> list[dict[str, Any]]:
    """Return the values of some keys of documents that are included, with the name that loads each."""
    return [
        {"name": name, **{key: getattr(included, key) for key in keys}}
        for name in names
        for included in [load(name)]
    ]


def _in_short(drive: DriveDocument) -> str:
    half = drive.inverter.supply_voltage_v
    # Without a tap the user has one supply, not two halves.
    supply = f"2 × {half:g} V" if drive.has_split_supply else f"{2.0 * half:g} V"
    return (
        f"{drive.machine.phases} phases, {2 * drive.machine.pole_pairs} poles, {drive.rating.rated_power_w:g} W, "
        f"{drive.rating.base_speed_rpm:g} rpm, {supply}"
    )


def show_cases(console: Console, document: dict[str, Any]) -> None:
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
    print_line(
        console,
        "next: drivegate simulate reference --case NAME runs a scenario (foc one of a PM AC drive), "
        "drivegate new scenario FILE writes one, --drive NAME takes a drive, "
        "drivegate compare A B --cycle NAME drives a cycle",
        "dim",
    )
