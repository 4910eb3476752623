"""What a simplification of a scenario is."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, TypeAlias

from drivegate_cases.scenario.scenario import Scenario

Fields: TypeAlias = dict[str, Any]
"""Fields of a scenario that change."""
Simplification: TypeAlias = Callable[[Scenario], Iterator[Fields]]
"""From a scenario to changes that make it simpler in one respect, the boldest first."""
