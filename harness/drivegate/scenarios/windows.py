"""The stretches of a run in which convergence is judged."""

from __future__ import annotations

from drivegate_cases.scenario.profile import dwells
from drivegate_cases.scenario.scenario import Scenario

SETTLING_TIME = 6.0
"""Time within which a candidate's search has to converge at a steady speed reference (s)."""
SHORTEST_WINDOW = 3.0
"""Shortest time over which convergence is judged (s)."""


def observed_windows(scenario: Scenario) -> list[tuple[float, float]]:
    """Find the stretches in which convergence is judged: from `SETTLING_TIME` into each long dwell to its end."""
    return [
        (dwell.start + SETTLING_TIME, dwell.end)
        for dwell in dwells(scenario)
        if dwell.duration >= SETTLING_TIME + SHORTEST_WINDOW - 1e-9
    ]
