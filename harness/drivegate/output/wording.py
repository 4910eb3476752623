"""Scenarios, margins and runs of a result in words, the same on every output."""

from __future__ import annotations

from collections.abc import Mapping
from shlex import quote
from types import MappingProxyType
from typing import Any, Final

from drivegate.checks.margin import margin_in_words
from drivegate.scenarios.traits import traits
from drivegate_cases.documents.wording import counted

_INCOMPLETE: Final = MappingProxyType(
    {"interrupted": "incomplete, interrupted after ", "max time": "incomplete, --max-time reached after "}
)


def scenario_in_short(scenario: dict[str, Any]) -> str:
    if scenario.get("kind") == "script":
        return f"{scenario['name']}: a script of {len(scenario['rows'])} rows"
    parts = [f"{scenario['duration_s']:g} s", *(trait.short for trait in traits(scenario) if trait.short)]
    return f"{scenario['name']}: {', '.join(parts)}"


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
    corpus = f", {result['corpus_runs']} of them from the corpus" if result["corpus_runs"] else ""
    focus = result.get("focus") or {}
    only = f"only {', '.join(focus['only'])}, " if focus.get("only") else ""
    early = "ended at the first failure after " if focus.get("stopped_at_first") else ""
    early = _INCOMPLETE.get(str(result.get("incomplete")), early)
    return f"{only}{early}{counted(result['runs'], 'run')}{corpus}, {result['set_aside']} set aside as infeasible"
