"""What of a run's commands was out of range and clamped, in words, with a guess at a wrong unit."""

from __future__ import annotations

from math import degrees
from typing import Final

from drivegate.contracts.current.checks.command_range import LARGEST_ANGLE
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.loop.closed_loop import ClosedLoopRun

_LEAST_IN_DEGREES: Final = 3.0
_MOST_IN_DEGREES: Final = 360.0
_MILLI: Final = 1000.0
_FAR_BEYOND: Final = 50.0


def clamped_in_words(scenario: Scenario, run: ClosedLoopRun) -> list[str]:
    """Tell the extremes of commands that were clamped before they reached the plant."""
    observed, limit = run.observed, scenario.drive.rating.current_limit_a
    words = []
    if observed.angle_highest > LARGEST_ANGLE:
        angle = observed.angle_highest
        wrong = _LEAST_IN_DEGREES <= angle <= _MOST_IN_DEGREES
        asked = f"{angle:.4g} rad: degrees?" if wrong else f"{angle:.4g} rad ({degrees(angle):.4g}°)"
        words.append(f"advance angle clamped to 90°: up to {asked}")
    if observed.angle_lowest < 0.0:
        angle = observed.angle_lowest
        words.append(f"advance angle clamped to 0: down to {angle:.4g} rad ({degrees(angle):.4g}°)")
    if observed.reference_highest > limit:
        current = observed.reference_highest
        hint = ": milliamperes?" if _FAR_BEYOND * limit < current <= _MILLI * limit else ""
        words.append(f"current reference clamped to its limit of {limit:g} A: up to {current:.4g} A{hint}")
    if observed.reference_lowest < 0.0:
        words.append(f"current reference clamped to 0: down to {observed.reference_lowest:.4g} A")
    return words
