"""What a drive can do, and how fast it is, as a document in people's units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from math import ceil, degrees, inf, isfinite, pi
from typing import Any, Final

from drivegate.drives.ability import rating_document
from drivegate.drives.envelope import (
    SpeedPoint,
    few_speeds_of,
    least_in_hand,
    recommended_line,
    speed_point,
    speed_without_advance,
)
from drivegate.drives.kinds import kind_of
from drivegate.drives.rating import RatedDrive, Rating, rated_drive
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import SPEED_TOLERANCE_SHARE
from drivegate_models.steady.oracle import AdvanceLine
from drivegate_models.units import RADIANS_PER_RPM

CYCLES_A_DECISION: Final = 5
"""Electrical cycles at base speed over which a search at least takes the mean of Σ|i|."""
FIRST_STEP_DEG: Final = 1.0
"""Step of a search, as the built-in controllers take it (deg)."""
LAST_DECISIONS: Final = 3
"""Decisions in which a search narrows its step and sees that nothing gets better."""
_KEPT: Final = 100


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


@lru_cache(maxsize=_KEPT)
def envelope_of(document: DriveDocument) -> dict[str, Any] | None:
    """Compute what a drive can do at a few speeds, as the results of its candidates show it; None without angles."""
    if not kind_of(document).has_angles:
        return None
    drive = rated_drive(document)
    line = recommended_line(drive)
    points = [speed_point(drive, line, speed) for speed in few_speeds_of(drive.rating)]
    return envelope_document(drive, line, points)


def envelope_document(drive: RatedDrive, line: AdvanceLine, points: Sequence[SpeedPoint]) -> dict[str, Any]:
    """Put together what a drive can do at some speeds, those of `few_speeds_of` among them."""
    rating = drive.rating
    # Of the same speeds whatever else there is, so that a result and `drivegate drive` show the same.
    few = few_speeds_of(rating)
    shared = [point for point in points if point.speed in few]
    loaded = [point for point in shared if _is_loaded(point, rating)]
    without_advance, in_hand = speed_without_advance(drive), least_in_hand(drive, line)
    scales = time_scales(drive, shared)
    units = {"electrical_frequency": "hz"}
    return {
        "rating": rating_document(drive.document),
        "has_band": drive.has_band,
        "line": {
            "start_deg": degrees(line.start),
            "slope_deg_per_rpm": degrees(line.slope) * RADIANS_PER_RPM,
            "least_in_hand_percent": None if in_hand is None else 100.0 * in_hand[1],
            "least_in_hand_at_rpm": None if in_hand is None else _rpm(in_hand[0]),
        },
        "rated_torque_without_advance_up_to_rpm": None if without_advance is None else _rpm(without_advance),
        "greatest_ripple_percent": max(
            (100.0 * point.ripple for point in loaded if point.ripple == point.ripple), default=None
        ),
        "time_scales": {
            **{f"{name}_{units.get(name, 's')}": value for name, value in asdict(scales).items()},
            "largest_control_period_s": scales.control_period,
        },
        "points": [_point(point) for point in points],
    }


def _rpm(speed: float) -> float:
    # The speeds have come from rpm, and the way back may cost the last digit.
    return round(speed / RADIANS_PER_RPM, 9)


def _is_loaded(point: SpeedPoint, rating: Rating) -> bool:
    rounding = 1e-9 * rating.highest_speed
    return rating.lowest_speed - rounding <= point.speed <= rating.highest_speed + rounding


def _point(point: SpeedPoint) -> dict[str, float]:
    return {
        "speed_rpm": _rpm(point.speed),
        "rated_torque_nm": point.rated_torque,
        "greatest_torque_nm": point.greatest_torque,
        "greatest_torque_deg": degrees(point.greatest_torque_advance),
        # Before friction; what is left of it at the shaft is `constant_power.greatest_shaft_power`.
        "greatest_power_w": point.greatest_torque * point.speed,
        "torque_without_advance_nm": point.torque_without_advance,
        "edge_deg": degrees(point.edge),
        "advance_deg": degrees(point.advance),
        "current_sum_a": point.current_sum,
        "input_power_w": point.input_power,
        "ripple_percent": 100.0 * point.ripple,
        "line_deg": degrees(point.line_advance),
        "line_torque_nm": point.line_torque,
    }
