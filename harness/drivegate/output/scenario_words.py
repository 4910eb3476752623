"""A scenario in one line, the same on the console and in reports."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from drivegate.scenarios.title import stated_supply
from drivegate_cases.drive.scales import FACTOR_SYMBOLS


def scenario_in_short(scenario: dict[str, Any]) -> str:
    """State a scenario in one line."""
    if scenario.get("kind") == "script":
        return f"{scenario['name']}: a script of {len(scenario['rows'])} rows"
    load = scenario["load"]
    parts = [f"{scenario['duration_s']:g} s", f"{_values(scenario['speed_rpm'])} rpm", _load(load)]
    if "supply_v" in scenario:
        name, volts = stated_supply(scenario["drive"]["kind"], scenario["supply_v"])
        parts.append(f"{name} {_values(volts)} V")
    parts += [
        f"{key} × {value:g}"
        for key, value in scenario.get("scales", {}).items()
        if key in FACTOR_SYMBOLS and value != 1.0
    ]
    added = scenario.get("scales", {}).get("friction_added_n_m", 0.0)
    if added:
        parts.append(f"{added:g} N·m of friction added")
    return f"{scenario['name']}: {', '.join(parts)}"


def _values(profile: Sequence[Sequence[float]]) -> str:
    values = [value for _, value in profile]
    distinct = [value for index, value in enumerate(values) if index == 0 or value != values[index - 1]]
    return " → ".join(f"{value:g}" for value in distinct)


def _load(load: dict[str, Any]) -> str:
    size = {"torque_nm": "N·m", "power_w": "W"}
    sizes = [f"{load[key]:g} {unit}" for key, unit in size.items() if key in load]
    factor = f" × {_values(load['factor'])}" if "factor" in load else ""
    return " ".join(["load", load["kind"].replace("_", " "), *sizes]) + factor
