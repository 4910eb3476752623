"""A simplification of a scenario, and how it is applied."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, TypeAlias

from drivegate.scenarios.size import size_of
from drivegate_cases.scenario.control_periods import on_whole_periods
from drivegate_cases.scenario.profile import dwell_torque, dwells
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError

Fields: TypeAlias = dict[str, Any]
"""Fields of a scenario that change."""
Simplification: TypeAlias = Callable[[Scenario], Iterator[Fields]]
"""From a scenario to changes that make it simpler in one respect, the boldest first."""


def simplified(scenario: Scenario, fields: Fields) -> Scenario | None:
    """Apply a change, if it gives a valid and simpler scenario that is still loaded where it was.

    An unloaded drive has hardly any current, so that shares of it say little: a failure there would be another one.
    """
    period = fields.get("control_period_s", scenario.control_period_s)
    if "duration_s" in fields:
        fields = fields | {"duration_s": on_whole_periods(fields["duration_s"], period)}
    try:
        simpler = scenario.replaced(**fields)
    except InputError:
        return None
    if _is_loaded(scenario) and not _is_loaded(simpler):
        return None
    return simpler if size_of(simpler.to_mapping()) < size_of(scenario.to_mapping()) else None


def _is_loaded(scenario: Scenario) -> bool:
    return any(dwell_torque(scenario, dwell) > 0.0 for dwell in dwells(scenario))
