"""Names and descriptions that say what a scenario is, made from its content."""

from __future__ import annotations

from drivegate.scenarios.traits import traits
from drivegate_cases.scenario.scenario import Scenario

_LONGEST_NAME = 200
_LONGEST_DESCRIPTION = 2000


def titled(scenario: Scenario) -> Scenario:
    """Name and describe a scenario by its content."""
    named = [trait for trait in traits(scenario.to_mapping()) if trait.label]
    return scenario.model_copy(
        update={
            "name": "-".join(trait.label for trait in named)[:_LONGEST_NAME],
            "description": f"{'; '.join(trait.words for trait in named)}."[:_LONGEST_DESCRIPTION],
        }
    )
