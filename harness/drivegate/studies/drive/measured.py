"""Torques that were measured or published, as a CSV file has them."""

from __future__ import annotations

from dataclasses import dataclass
from math import isnan, nan, radians
from pathlib import Path
from typing import Final

from drivegate.drives.drive_kind import Drive, Oracle
from drivegate_cases.documents.csv_file import read_columns
from drivegate_cases.documents.wording import shown_path
from drivegate_models.errors import InputError
from drivegate_models.units import RADIANS_PER_RPM

REQUIRED: Final = ("speed_rpm", "torque_nm")
"""Columns that a file must have."""
OPTIONAL: Final = ("advance_deg", "current_a", "uncertainty_nm")
"""Columns that it may have."""
MOST_POINTS: Final = 1000
"""Points that a file may have at most."""
_HIGHEST_ANGLE: Final = 90.0
_HIGHEST_SPEED: Final = 1e6


@dataclass(frozen=True)
class MeasuredTorque:
    """A mean torque that was measured or published."""

    speed_rpm: float
    """Speed (rpm)."""
    torque: float
    """Mean electromagnetic torque (N·m)."""
    advance_deg: float = nan
    """Advance angle (deg); NaN for that of the greatest torque."""
    current: float = nan
    """Current reference (A); NaN for the current limit."""
    uncertainty: float = nan
    """Standard uncertainty of the torque (N·m); NaN where it is not known."""

    def torque_of(self, oracle: Oracle, constants: Drive) -> float:
        """Return the torque that a drive has there (N·m)."""
        # A current reference gives what it would as the limit.
        at = constants if isnan(self.current) else constants._replace(current_limit=self.current)
        speed = self.speed_rpm * RADIANS_PER_RPM
        if isnan(self.advance_deg):
            return oracle.greatest_torque_at_limit(at, speed).torque
        return float(oracle.torques_at_limit(at, speed, [radians(self.advance_deg)])[0])


def read_measured(path: Path) -> tuple[MeasuredTorque, ...]:
    """Read measured torques from a CSV file."""
    where = shown_path(path)
    rows = read_columns(path, REQUIRED, OPTIONAL, what="measured torques")
    if not 0 < len(rows) <= MOST_POINTS:
        raise InputError(f"{where} has {len(rows)} points, but must have 1 to {MOST_POINTS}")
    points = tuple(MeasuredTorque(*row) for row in rows)
    for number, point in enumerate(points, 1):
        problem = _problem(point)
        if problem:
            raise InputError(f"{where}: {problem} in point {number}")
    if len({isnan(point.uncertainty) for point in points}) > 1:
        raise InputError(f"{where}: 'uncertainty_nm' is given for some points, but must be for all or none")
    return points


def _problem(point: MeasuredTorque) -> str:
    """State the first value that cannot be."""
    if not 0.0 < point.speed_rpm <= _HIGHEST_SPEED:
        return f"'speed_rpm' is {point.speed_rpm:g}, but must be above 0 and up to {_HIGHEST_SPEED:g}"
    if not (isnan(point.advance_deg) or 0.0 <= point.advance_deg <= _HIGHEST_ANGLE):
        return f"'advance_deg' is {point.advance_deg:g}, but must be from 0 to {_HIGHEST_ANGLE:g}, or empty"
    if point.current <= 0.0:
        return f"'current_a' is {point.current:g}, but must be above 0, or empty for the current limit"
    if point.uncertainty <= 0.0:
        return f"'uncertainty_nm' is {point.uncertainty:g}, but must be above 0"
    return ""
