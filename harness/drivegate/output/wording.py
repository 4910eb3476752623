"""Scenarios, margins and runs of a result in words, the same on every output."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from shlex import quote
from types import MappingProxyType
from typing import Any, Final

from drivegate.checks.margin import margin_in_words
from drivegate.scenarios.title import stated_supply
from drivegate_cases.documents.wording import counted
from drivegate_cases.drive.plant import FACTOR_SYMBOLS

_INCOMPLETE: Final = MappingProxyType(
    {"interrupted": "incomplete, interrupted after ", "max time": "incomplete, --max-time reached after "}
)


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


def printed_margin(document: dict[str, Any], check: dict[str, Any]) -> str:
    """Write the margin of a check for people, also of one that depends on the machine."""
    timed = document["timing"].get("checks", {}).get(check["id"], {})
    margin = timed.get("margin") if check["margin"] is None else check["margin"]
    return "–" if margin is None else margin_in_words(margin)


def drive_option(document: Mapping[str, Any]) -> str:
    """Write the option that names the drive of a result again, with the space before it."""
    named = (document.get("drive") or {}).get("specification")
    return "" if named is None else f" --drive {quote(str(named))}"


def drive_in_words(drive: Mapping[str, Any]) -> str:
    """Name the drive of a result, and its control period and delay where these are unusual."""
    inverter = (drive.get("document") or {}).get("inverter", {})
    words, every = [str(drive["name"])], inverter.get("control_every") or 1
    if every > 1:
        period = 1e6 * every / inverter["carrier_frequency_hz"]
        words.append(f"a step every {every} carrier periods ({period:.4g} µs)")
    if inverter.get("update_delay") == 0:
        words.append("answers act in the period of their sample")
    return ", ".join(words)


def runs_in_short(result: dict[str, Any]) -> str:
    """State how many runs a result rests on."""
    corpus = f", {result['corpus_runs']} of them from the corpus" if result["corpus_runs"] else ""
    focus = result.get("focus") or {}
    only = f"only {', '.join(focus['only'])}, " if focus.get("only") else ""
    early = "ended at the first failure after " if focus.get("stopped_at_first") else ""
    early = _INCOMPLETE.get(str(result.get("incomplete")), early)
    return f"{only}{early}{counted(result['runs'], 'run')}{corpus}, {result['set_aside']} set aside as infeasible"
