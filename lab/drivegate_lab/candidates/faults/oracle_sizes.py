"""Sizes of faults that follow from what the drive can do at best: its feasible edges and its optimum."""

from __future__ import annotations

from functools import lru_cache
from math import degrees, floor, isnan, radians
from typing import TYPE_CHECKING, Final

from drivegate_cases.drive.advance import advance_line
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.drive.requirements import points_of
from drivegate_lab.candidates.faults.sizes import Size
from drivegate_models.units import RADIANS_PER_RPM

if TYPE_CHECKING:
    from drivegate_cases.drive.drive_document import DriveDocument

_KEPT: Final = 100
# What an edge has to be above an angle for the lack of torque to show (deg).
_VISIBLE: Final = 0.5
_SHARES_BEYOND: Final = (1.0, 0.75, 0.5, 0.25)
# What a line's angle at base speed has above that of least advance where it is made for weaker machines too (deg).
_IN_HAND: Final = 1.0
_TABLE_SHARES: Final = (0.05, 0.1, 0.2, 0.5, 0.65, 0.7, 0.85)
# Added to the edge by a table of the nominal drive (deg).
_TO_SPARE: Final = 1.5
_TOLERANCES_BESIDE: Final = 3.0
_MOST_BESIDE: Final = 16
_SHARE_NEAR: Final = 0.45
_SPEEDS_NEAR: Final = (0.5, 0.75, 1.0)
_FINE_STEP: Final = 0.05
_FINE_STEPS: Final = 21


@lru_cache(maxsize=_KEPT)
def _edge_at_rated_power(drive: DriveDocument, speed_rpm: float) -> float:
    """Return the least angle that gives rated power (deg); NaN where none does."""
    from drivegate_models.steady.oracle import demanded_torque

    rating, plant = drive.rating, drive.plant()
    base, speed = rating.base_speed_rpm * RADIANS_PER_RPM, speed_rpm * RADIANS_PER_RPM
    return _edge(drive, speed, demanded_torque(plant, speed, base, rating.rated_power_w))


@lru_cache(maxsize=_KEPT)
def _edge_at_point(drive: DriveDocument) -> float:
    """Return the least angle that gives the required point of greatest speed (deg)."""
    point = max(points_of(drive), key=lambda point: point.speed_rpm)
    return _edge(drive, point.speed_rpm * RADIANS_PER_RPM, point.torque_n_m)


def _edge(drive: DriveDocument, speed: float, torque: float) -> float:
    from drivegate_models.steady.oracle import feasible_edge

    return degrees(feasible_edge(drive.plant(), speed, torque))


def _below_point(drive: DriveDocument) -> float:
    return float(floor(_edge_at_point(drive) - _VISIBLE))


def no_angle_below_point(drive: DriveDocument) -> str | None:
    """State why there is no angle below what the required point takes."""
    if _below_point(drive) > 0.0:
        return None
    return "the required point needs no advance"


def _edge_beyond(drive: DriveDocument) -> float:
    """Return the least angle of rated power at the greatest speed up to overspeed that has one (deg)."""
    rating = drive.rating
    for part in _SHARES_BEYOND:
        speed = rating.highest_speed_rpm + part * (rating.overspeed_rpm - rating.highest_speed_rpm)
        edge = _edge_at_rated_power(drive, speed)
        if not isnan(edge):
            return edge
    return _edge_at_rated_power(drive, rating.highest_speed_rpm)


def _enough_to_highest(drive: DriveDocument) -> float:
    return float(
        floor(0.5 * (_edge_at_rated_power(drive, drive.rating.highest_speed_rpm) + _edge_beyond(drive)))
    )


def no_more_angle_beyond(drive: DriveDocument) -> str | None:
    """State why an angle that is enough at the highest speed is so beyond, too."""
    cap = _enough_to_highest(drive)
    if _edge_beyond(drive) - cap >= _VISIBLE and cap > 0.0:
        return None
    return "beyond the highest speed rated power takes no more angle than up to it, or is out of reach"


@lru_cache(maxsize=_KEPT)
def _nominal_line(drive: DriveDocument) -> tuple[float, float]:
    """Return the angle at base speed (deg) and the slope (deg a rpm) of a line that is enough for the nominal machine.

    That of the drive, unless it is made for weaker machines too: then the one of least advance.
    """
    own, least = advance_line(drive), advance_line(drive.model_copy(update={"advance": None}))
    start, slope = least if degrees(own[0] - least[0]) > _IN_HAND else own
    return degrees(start), degrees(slope) * RADIANS_PER_RPM


def line_of_nominal_machine() -> tuple[tuple[str, Size], ...]:
    """Return the constants of a controller with such a line."""
    return (
        ("angle_at_base", Size(lambda drive: _nominal_line(drive)[0], "°")),
        ("angle_slope", Size(lambda drive: _nominal_line(drive)[1], "° a rpm")),
    )


@lru_cache(maxsize=_KEPT)
def nominal_table(drive: DriveDocument) -> tuple[tuple[float, float], ...]:
    """Make a table of speeds (rpm) and angles that give rated power on the nominal drive (deg)."""
    rating = drive.rating
    span = rating.highest_speed_rpm - rating.base_speed_rpm
    rows = []
    for part in _TABLE_SHARES:
        speed = rating.base_speed_rpm + part * span
        rows.append((speed, _edge_at_rated_power(drive, speed)))
    rows.append((rating.highest_speed_rpm, _edge_at_point(drive)))
    rows.append((rating.overspeed_rpm, _edge_beyond(drive)))
    angle, table = 0.0, []
    for speed, edge in rows:
        angle = angle if isnan(edge) else round(edge + _TO_SPARE, 1)
        table.append((speed, angle))
    return tuple(table)


@lru_cache(maxsize=_KEPT)
def _excesses(drive: DriveDocument, part: float, angles: tuple[float, ...]) -> tuple[float, ...]:
    """Return what angles above the optimum (deg) cost at rated power, over the tolerance; a share of the speed range.

    NaN where an angle gives no torque any more.
    """
    from drivegate_models.steady.oracle import (
        current_sum_curve,
        demanded_torque,
        least_current_sum,
    )

    rating, plant = drive.rating, drive.plant()
    base, highest = rating.base_speed_rpm * RADIANS_PER_RPM, rating.highest_speed_rpm * RADIANS_PER_RPM
    speed = base + part * (highest - base)
    torque = demanded_torque(plant, speed, base, rating.rated_power_w)
    best = least_current_sum(plant, speed, torque)
    advances = [best.advance + radians(angle) for angle in angles]
    sums = current_sum_curve(plant, speed, torque, advances).current_sum
    allowed = limits_of(drive).optimum_tolerance * best.current_sum
    return tuple(float((found - best.current_sum) / allowed) for found in sums)


def _above_optimum(drive: DriveDocument) -> float:
    """Return the least whole angle above the optimum that costs three times too much at the highest speed (deg)."""
    angles = tuple(map(float, range(1, _MOST_BESIDE)))
    excesses = zip(angles, _excesses(drive, 1.0, angles), strict=True)
    # An angle that gives no torque any more is far off, too.
    return next((angle for angle, excess in excesses if not excess < _TOLERANCES_BESIDE), float(_MOST_BESIDE))


def _near_optimum(drive: DriveDocument) -> float:
    """Return the greatest angle above the optimum that costs less than half of what is allowed at any speed (deg)."""
    angles = tuple(round(_FINE_STEP * number, 2) for number in range(1, _FINE_STEPS))
    by_speed = [_excesses(drive, part, angles) for part in _SPEEDS_NEAR]
    cheap = [
        angle for number, angle in enumerate(angles) if all(row[number] < _SHARE_NEAR for row in by_speed)
    ]
    return max(cheap, default=_FINE_STEP)


BELOW_POINT: Final = Size(_below_point, "°")
"""An angle below what the required point takes."""
ENOUGH_TO_HIGHEST: Final = Size(_enough_to_highest, "°")
"""An angle that gives rated power at the highest speed, and not beyond."""
ABOVE_OPTIMUM: Final = Size(_above_optimum, "°")
"""An angle above the optimum that costs too much."""
NEAR_OPTIMUM: Final = Size(_near_optimum, "°")
"""An angle above the optimum that costs less than is allowed."""
