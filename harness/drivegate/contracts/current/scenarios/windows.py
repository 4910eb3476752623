"""The stretches of a run in which convergence is judged."""

from __future__ import annotations

from drivegate.scenarios.drive_scale import scale_of
from drivegate_cases.scenario.profile import dwells
from drivegate_cases.scenario.scenario import Scenario


def observed_windows(scenario: Scenario) -> list[tuple[float, float]]:
    """Find the stretches in which convergence is judged: from the settling time into each long dwell to its end."""
    scale = scale_of(scenario.drive)
    return [
        (dwell.start + scale.settling_s, dwell.end)
        for dwell in dwells(scenario)
        if dwell.duration >= scale.settling_s + scale.shortest_window_s - 1e-9
    ]
