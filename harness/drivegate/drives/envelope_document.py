"""What a drive can do as a document, in people's units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from functools import lru_cache
from math import degrees
from typing import TYPE_CHECKING, Any, Final

from drivegate.drives.ability import rating_document
from drivegate.drives.envelope import (
    SpeedPoint,
    envelope,
    few_speeds_of,
    least_in_hand,
    recommended_line,
    speed_without_advance,
)
from drivegate.drives.kinds import kind_of
from drivegate.drives.rating import RatedDrive, Rating, rated_drive
from drivegate.drives.time_scales import TimeScales, time_scales
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_models.units import RADIANS_PER_RPM

if TYPE_CHECKING:
    from drivegate.drives.drive_kind import AdvanceLine

_KEPT: Final = 100


@lru_cache(maxsize=_KEPT)
def envelope_of(document: DriveDocument) -> dict[str, Any] | None:
    """Compute what a drive can do at a few speeds, as the results of its candidates show it; None without angles."""
    if kind_of(document).angles is None:
        return None
    drive = rated_drive(document)
    line = recommended_line(drive)
    points = tuple(envelope(drive, line, few_speeds_of(drive.rating)))
    return envelope_document(drive, line, points)


def envelope_document(drive: RatedDrive, line: AdvanceLine, points: Sequence[SpeedPoint]) -> dict[str, Any]:
    """Put together what a drive can do at some speeds, those of `few_speeds_of` among them."""
    rating = drive.rating
    # Of the same speeds whatever else there is, so that a result and `drivegate drive` show the same.
    few = few_speeds_of(rating)
    shared = [point for point in points if point.speed in few]
    loaded = [point for point in shared if _is_loaded(point, rating)]
    without_advance = speed_without_advance(drive)
    return {
        "rating": rating_document(drive.document),
        "has_band": drive.has_band,
        "line": {
            "start_deg": degrees(line.start),
            "slope_deg_per_rpm": degrees(line.slope) * RADIANS_PER_RPM,
            **_least_in_hand(drive, line),
        },
        "rated_torque_without_advance_up_to_rpm": None if without_advance is None else _rpm(without_advance),
        "greatest_ripple_percent": max(
            (100.0 * point.ripple for point in loaded if point.ripple == point.ripple), default=None
        ),
        "time_scales": _time_scales(time_scales(drive, shared)),
        "points": [_point(point) for point in points],
    }


def _time_scales(scales: TimeScales) -> dict[str, float]:
    units = {"electrical_frequency": "hz"}
    named = {f"{name}_{units.get(name, 's')}": value for name, value in asdict(scales).items()}
    return named | {"largest_control_period_s": scales.control_period}


def _rpm(speed: float) -> float:
    # The speeds have come from rpm, and the way back may cost the last digit.
    return round(speed / RADIANS_PER_RPM, 9)


def _is_loaded(point: SpeedPoint, rating: Rating) -> bool:
    rounding = 1e-9 * rating.highest_speed
    return rating.lowest_speed - rounding <= point.speed <= rating.highest_speed + rounding


def _least_in_hand(drive: RatedDrive, line: AdvanceLine) -> dict[str, float | None]:
    """Return how much torque the line has above rated torque where it is least."""
    found = least_in_hand(drive, line)
    if found is None:
        return {"least_in_hand_percent": None, "least_in_hand_at_rpm": None}
    speed, in_hand = found
    return {"least_in_hand_percent": 100.0 * in_hand, "least_in_hand_at_rpm": _rpm(speed)}


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
