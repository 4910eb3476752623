"""The recorded trace of a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from drivegate_cases.scenario.scenario import Scenario

Columns: TypeAlias = dict[str, NDArray[np.float64]]
"""Arrays of equal length, shape (n,), by the name of the column, which has the unit."""


@dataclass(frozen=True)
class RecordedTrace:
    """The signals of a run, each a mean over a stretch of it."""

    scenario: Scenario
    """The scenario of the run."""
    columns: Columns
    """Its signals."""
    judged_s: tuple[float, float]
    """Start and end of the stretch that the check was judged on (s)."""
