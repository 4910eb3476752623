"""How fast a drive is, and what that means for a controller's period and for the time that it takes to settle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, degrees, inf, isfinite, pi
from typing import Final

from drivegate.drives.envelope import SpeedPoint
from drivegate.drives.rating import RatedDrive
from drivegate_cases.drive.limits import SPEED_TOLERANCE_SHARE

CYCLES_A_DECISION: Final = 5
"""Electrical cycles at base speed over which a search at least takes the mean of Σ|i|."""
FIRST_STEP_DEG: Final = 1.0
"""Step of a search, as the built-in controllers take it (deg)."""
LAST_DECISIONS: Final = 3
"""Decisions in which a search narrows its step and sees that nothing gets better."""


@dataclass(frozen=True)
class TimeScales:
    """Times that follow from a drive's constants and its rating."""

    electrical: float
    """Time constant of a winding, L/R; infinite without resistance (s)."""
    current_rise: float
    """Time in which half of the supply drives the current up to its limit at standstill, L·I/V (s)."""
    mechanical_at_base: float
    mechanical_at_highest: float
    """Time in which rated torque accelerates the shaft by its whole speed there, J·ω/T (s)."""
    run_up: float
    """Time from base speed to the highest with rated power, J·(ω₂² − ω₁²)/(2·P) (s)."""
    electrical_frequency: float
    """Electrical frequency at the highest speed (Hz)."""
    half_cycle: float
    """Half an electrical cycle there, in which a command reaches each phase once (s)."""
    drift: float
    """Time in which the shaft, at base speed, loses `SPEED_TOLERANCE_SHARE` of it without rated torque (s).
    """
    decision: float
    """Time for which a search watches Σ|i| before it moves again (s)."""
    search: float
    """Time that a search takes from the recommended line to the least Σ|i|, at the speed where it is farthest
    (s); NaN without a line."""

    @property
    def control_period(self) -> float:
        """Largest sensible control period (s): a command reaches each phase, and a lost torque is seen in time."""
        return min(self.half_cycle, self.drift)


def time_scales(drive: RatedDrive, points: Sequence[SpeedPoint]) -> TimeScales:
    """Derive the time scales of a drive from its constants and from what it can do."""
    constants, rating = drive.constants, drive.rating
    at_base, at_highest = (
        constants.inertia * speed / drive.demanded_torque(speed)
        for speed in (rating.base_speed, rating.highest_speed)
    )
    frequency = constants.pole_pairs * rating.highest_speed / (2.0 * pi)
    cycle_at_base = 2.0 * pi / (constants.pole_pairs * rating.base_speed)
    decision = max(at_base, CYCLES_A_DECISION * cycle_at_base)
    return TimeScales(
        electrical=constants.inductance / constants.resistance if constants.resistance > 0.0 else inf,
        current_rise=constants.inductance * constants.current_limit / constants.half_supply_voltage,
        mechanical_at_base=at_base,
        mechanical_at_highest=at_highest,
        run_up=constants.inertia
        * (rating.highest_speed * rating.highest_speed - rating.base_speed * rating.base_speed)
        / (2.0 * rating.power),
        electrical_frequency=frequency,
        half_cycle=0.5 / frequency,
        drift=SPEED_TOLERANCE_SHARE * at_base,
        decision=decision,
        search=decision * _decisions(drive, points),
    )


def _decisions(drive: RatedDrive, points: Sequence[SpeedPoint]) -> float:
    """Count the decisions of a search where the line is farthest from the optimum."""
    rating = drive.rating
    ways = [
        abs(degrees(point.line_advance - point.advance))
        for point in points
        if rating.base_speed <= point.speed <= rating.highest_speed * (1.0 + 1e-9)
        and isfinite(point.advance)
        and isfinite(point.line_advance)
    ]
    return ceil(max(ways) / FIRST_STEP_DEG) + LAST_DECISIONS if ways else float("nan")
