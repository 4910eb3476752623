"""The facts of a scenario: what of it is not as in the plain run, rated torque at the highest required speed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from drivegate.scenarios.traits import traits_of

PLAIN_RUN: Final = "the plain run"
"""What is said of a scenario without any fact."""
_ELSEWHERE: Final = frozenset({"schema", "name", "description", "drive", "seed", "initial_speed_rpm"})


def facts_of(scenario: Mapping[str, Any]) -> tuple[str, ...]:
    """State what of a scenario, as plain data, is not as in the plain run; one text for each key that differs."""
    if scenario.get("kind") == "script":
        return (f"a script of {len(scenario.get('rows', ()))} rows",)
    keys = (key for key in scenario if key not in _ELSEWHERE)
    return tuple(trait.fact for key in keys for trait in traits_of(key, scenario) if trait.fact)


def facts_in_short(scenario: Mapping[str, Any]) -> str:
    return ", ".join(facts_of(scenario)) or PLAIN_RUN
