"""The best that a PM AC drive could have done at an operating point, as its checks look it up.

The plant is imported where it is used: the catalogue has these checks beside those of drives that never need it.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

from drivegate.scenarios.rotation import sense_of

if TYPE_CHECKING:
    from drivegate_models.pm_ac.fundamental import SteadyState
    from drivegate_models.pm_ac.oracle import Limits
    from drivegate_models.pm_ac.plant.drive import PmAcDrive

Purpose: TypeAlias = Literal["current", "loss"]
"""What is to be least."""

_KEPT: Final = 20_000
_UNLIMITED_V: Final = 1e9


def undistorted(link: float) -> float:
    """Return the greatest peak voltage of a phase that a link gives without distortion (V)."""
    from drivegate_models.pm_ac.fundamental import LINEAR_LIMIT

    return LINEAR_LIMIT * link


@lru_cache(maxsize=_KEPT)
def greatest_at(drive: PmAcDrive, speed: float, link: float, *, weakens: bool = True) -> SteadyState:
    """Find the steady state of the greatest torque in the sense of rotation, within the limits of current and link."""
    from drivegate_cases.drive.pm_ac.greatest_torque import greatest_within
    from drivegate_models.pm_ac.oracle import undistorted_limits

    limits = undistorted_limits(drive, link)
    return _in_sense(speed, greatest_within(drive, limits, abs(speed), weakens=weakens))


@lru_cache(maxsize=_KEPT)
def least_within(drive: PmAcDrive, speed: float, link: float, torque: float, purpose: Purpose) -> SteadyState:
    """Find the steady state of least current or loss that gives a torque within the limits of current and link."""
    from drivegate_models.pm_ac.oracle import undistorted_limits

    return _least(drive, undistorted_limits(drive, link), speed, torque, purpose)


@lru_cache(maxsize=_KEPT)
def least_free(
    drive: PmAcDrive, speed: float, torque: float, voltage: float = _UNLIMITED_V, purpose: Purpose = "current"
) -> SteadyState:
    """Find the steady state of least current, or loss, for a torque, whatever voltage it takes or within one (V)."""
    from drivegate_models.pm_ac.oracle import Limits

    return _least(drive, Limits(2.0 * drive.current_limit, voltage), speed, torque, purpose)


def _least(drive: PmAcDrive, limits: Limits, speed: float, torque: float, purpose: Purpose) -> SteadyState:
    from drivegate_models.pm_ac.oracle import CURRENT, LOSS, least_at

    aim = LOSS if purpose == "loss" else CURRENT
    return _in_sense(speed, least_at(drive, limits, abs(speed), sense_of(speed) * torque, aim))


def _in_sense(speed: float, forward: SteadyState) -> SteadyState:
    """Mirror a steady state of forward rotation where the speed is backward: q current and torque change sign."""
    if speed >= 0.0:
        return forward
    return forward._replace(quadrature=-forward.quadrature, torque=-forward.torque)
