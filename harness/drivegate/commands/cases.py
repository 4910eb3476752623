"""``drivegate cases``: the scenarios, operating points, sweeps, drive cycles and motors that come with drivegate."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import json_option

if TYPE_CHECKING:
    from rich.console import Console

SCHEMA = 1


@click.command("cases")
@json_option
def command() -> Outcome:
    """List the scenarios, operating points, sweeps, drive cycles and motors that come along."""
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "scenarios": _scenarios(),
        "operating_points": _operating_points(),
        "sweeps": _sweeps(),
        "drive_cycles": _drive_cycles(),
        "motors": _motors(),
    }
    return Outcome(document, lambda console: _show(console, document))


def _scenarios() -> list[dict[str, Any]]:
    from drivegate_cases.scenario.scenario import load_scenario, scenario_names

    return [
        {
            "name": name,
            "description": scenario.description,
            "motor": scenario.motor.name,
            "duration_s": scenario.duration_s,
        }
        for name in scenario_names()
        for scenario in [load_scenario(name)]
    ]


def _operating_points() -> list[dict[str, Any]]:
    from drivegate_cases.scenario.operating_point import load_operating_point, operating_point_names

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
    from drivegate_cases.scenario.operating_point import load_power_sweep, power_sweep_names

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
    from drivegate_cases.scenario.drive_cycle import cycle_names, load_drive_cycle

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


def _motors() -> list[dict[str, Any]]:
    from drivegate_cases.motor.motor import load_motor, motor_names

    return [
        {
            "name": name,
            "description": f"{motor.phases} phases, {2 * motor.pole_pairs} poles, {motor.rated_power_w:g} W, "
            f"{motor.base_speed_rpm:g} rpm, 2 × {motor.supply_voltage_v:g} V",
        }
        for name in motor_names()
        for motor in [load_motor(name)]
    ]


def _show(console: Console, document: dict[str, Any]) -> None:
    from drivegate.output.console import plain, table

    for key, heading in (
        ("scenarios", "scenario"),
        ("operating_points", "operating point"),
        ("sweeps", "sweep"),
        ("drive_cycles", "drive cycle"),
        ("motors", "motor"),
    ):
        listed = table(heading, "description")
        for row in document[key]:
            listed.add_row(plain(row["name"]), plain(row["description"]))
        console.print(listed)
    console.print(
        plain(
            "next: drivegate simulate reference --case NAME runs a scenario, --motor NAME takes a motor, "
            "drivegate compare A B --cycle NAME drives a cycle",
            "dim",
        )
    )
