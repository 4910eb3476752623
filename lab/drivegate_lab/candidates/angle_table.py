"""A table of advance angles over speed and current sum, with the minimum current sum of each load.

A controller that cannot measure the torque uses the current sum instead, so the table contains the sum at its angle.
"""

from __future__ import annotations

from math import inf, isfinite, isnan, radians
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.steady.advance_line import demanded_torque
from drivegate_models.steady.angle_search import reaches, torque_demand
from drivegate_models.steady.oracle import current_sum_curve, least_current_sum
from drivegate_models.steady.plant import AnyDrive

LOADS: tuple[float, ...] = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1)
"""Load of each column, as a share of rated power (1)."""

# Minimum distance of the table from the feasible edge, below which the torque is lost.
_MARGIN = radians(0.3)
# Added to the angle if no angle produces the load's torque (rad).
_EXTENDED = radians(4.0)


class AngleTable(NamedTuple):
    """A row for each speed, a column for each of `LOADS`."""

    first_speed: float
    """Speed of the first row (rad/s)."""
    speed_step: float
    """Speed step between rows (rad/s)."""
    current_sums: NDArray[np.float64]
    """Sum of current magnitudes at the angle, shape (n, 11) (A)."""
    angles: NDArray[np.float64]
    """Advance angles, shape (n, 11) (rad electrical)."""


def angle_table(
    drive: AnyDrive,
    base_speed: float,
    last_speed: float,
    rows: int,
    rated_power: float,
    *,
    banded: bool = False,
) -> AngleTable:
    """Return the table of a drive.

    Each angle is that of the minimum current sum, but not less than that of a lighter load, and at least 0.3 degrees
    off the feasible edge. If no angle produces the torque, the row is extrapolated.

    Parameters
    ----------
    drive : AnyDrive
        Constants of machine and inverter.
    base_speed, last_speed : float
        Speeds of the first row and of the last (rad/s).
    rows : int
        Number of rows, evenly apart in speed.
    rated_power : float
        Rated power (W).
    banded : bool
        True for optima of the drive with its regulators' band, which need several times as long and differ only at
        light load. The current sums are those with the band in any case.

    Returns
    -------
    AngleTable
        With shape (rows, 11) arrays.
    """
    searched = drive if banded else drive._replace(hysteresis_band=0.0)
    sums, angles = np.empty((rows, len(LOADS))), np.empty((rows, len(LOADS)))
    step = (last_speed - base_speed) / (rows - 1)
    for row in range(rows):
        speed = base_speed + row * step
        angle = 0.0
        for column, load in enumerate(LOADS):
            torque = load * rated_power / speed + demanded_torque(drive, speed, base_speed, 0.0)
            found = _angle_for(searched, speed, torque, angle)
            sum_there = _sum_at(drive, speed, torque, found)
            if not isfinite(sum_there):
                found = angle + (_EXTENDED if column else 0.0)
                sum_there = sums[row, column - 1] * load / LOADS[column - 1] if column else _lightest(drive)
            angle = found
            sums[row, column], angles[row, column] = sum_there, angle
    return AngleTable(base_speed, step, sums, angles)


def _angle_for(drive: AnyDrive, speed: float, torque: float, lowest: float) -> float:
    """Return the angle of minimum current sum, limited by a lowest angle and the edge (rad); NaN if infeasible."""
    best = least_current_sum(drive, speed, torque).advance
    if isnan(best):
        return best
    demand = torque_demand(drive, speed, torque)
    if reaches(demand, best - _MARGIN) if best > _MARGIN else reaches(demand, 0.0):
        return max(best, lowest)
    off_edge = best + _MARGIN
    return max(off_edge if reaches(demand, off_edge) else best, lowest)


def _sum_at(drive: AnyDrive, speed: float, torque: float, angle: float) -> float:
    if isnan(angle):
        return inf
    return float(current_sum_curve(drive, speed, torque, [angle]).current_sum[0])


def _lightest(drive: AnyDrive) -> float:
    return LOADS[0] * drive.current_limit
