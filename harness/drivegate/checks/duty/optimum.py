"""The best that a PM AC drive could have done at an operating point, as its checks look it up."""

from __future__ import annotations

from functools import lru_cache
from typing import Final

from drivegate_models.pm_ac.fundamental import LINEAR_LIMIT, SteadyState
from drivegate_models.pm_ac.oracle import CURRENT, LOSS, Limits, greatest_torque, least_at, undistorted_limits
from drivegate_models.pm_ac.plant.drive import PmAcDrive

__all__ = ["CURRENT", "LOSS", "greatest_at", "least_free", "least_within", "undistorted"]

_KEPT: Final = 20_000
_UNLIMITED_V: Final = 1e9


def undistorted(link: float) -> float:
    """Give the greatest peak voltage of a phase that a link gives without distortion (V)."""
    return LINEAR_LIMIT * link


@lru_cache(maxsize=_KEPT)
def greatest_at(drive: PmAcDrive, speed: float, link: float) -> SteadyState:
    """Find the steady state of the greatest torque within the limits of current and link."""
    return greatest_torque(drive, undistorted_limits(drive, link), speed)


@lru_cache(maxsize=_KEPT)
def least_within(drive: PmAcDrive, speed: float, link: float, torque: float, purpose: int) -> SteadyState:
    """Find the steady state of least current or loss that gives a torque within the limits of current and link."""
    return least_at(drive, undistorted_limits(drive, link), speed, torque, purpose)


@lru_cache(maxsize=_KEPT)
def least_free(
    drive: PmAcDrive, speed: float, torque: float, voltage: float = _UNLIMITED_V, purpose: int = CURRENT
) -> SteadyState:
    """Find the steady state of least current, or loss, for a torque, whatever voltage it takes or within one (V)."""
    return least_at(drive, Limits(2.0 * drive.current_limit, voltage), speed, torque, purpose)
