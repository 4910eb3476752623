"""Points at which a torque ripple is required that no controller at the least current sum can have."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import ceil, degrees, isfinite, nan, radians
from typing import Final

from drivegate.drives.power_reach import setting_words
from drivegate.drives.rating import RatedDrive
from drivegate_cases.documents.wording import rounded_to_digits
from drivegate_cases.drive.limits import POINT_POWER_SHARE
from drivegate_cases.drive.requirements import RequiredPoint, points_of
from drivegate_models.machine.friction import friction_torque
from drivegate_models.steady import oracle
from drivegate_models.units import RADIANS_PER_RPM

_STEP: Final = radians(0.25)
_MOST_STEPS: Final = 80
_BELOW_GREATEST: Final = 0.999
"""Share of the greatest torque that is offered, since a point's torque is rounded (1)."""


@dataclass(frozen=True)
class UnreachableRipple:
    """A required point whose ripple, or torque, is out of reach."""

    speed_rpm: float
    """Speed of the point (rpm)."""
    torque_nm: float
    """Its torque (N·m)."""
    limit: float
    """Limit of the ripple with the ideal regulator, peak to peak over mean (1)."""
    least: float
    """Least ripple at the angles that CNV-2 allows (1); NaN where the torque is out of reach."""
    advance: float
    """Angle of the least ripple (rad electrical)."""
    greatest: float
    """Greatest ripple at these angles (1); NaN where the torque is out of reach."""
    tolerance: float
    """Excess of the current sum that CNV-2 allows (1)."""
    greatest_torque: float
    """Greatest torque of the shaft at the speed (N·m)."""
    follows_rating: bool
    """Whether the point follows from rated power, rather than being stated."""

    @property
    def accepted(self) -> tuple[Mapping[str, float], ...]:
        """The change that a check accepts, by its key; none where the drive delivers no torque at the point."""
        if isfinite(self.least):
            return ({"ripple_percent": self.nearest_percent},)
        torque = rounded_to_digits(_BELOW_GREATEST * self.greatest_torque, up=False)
        if torque == 0.0:
            return ()
        if self.follows_rating:
            power = torque * self.speed_rpm * RADIANS_PER_RPM / POINT_POWER_SHARE
            return ({"rated_power_w": rounded_to_digits(power, up=False)},)
        return ({"torque_n_m": torque},)

    def sentence(self) -> str:
        point = f"{self.torque_nm:.3g} N·m at {self.speed_rpm:g} rpm"
        accepted = "".join(f"; a check accepts {setting_words(changes)}" for changes in self.accepted)
        if not isfinite(self.least):
            follows = " (2.6 % above rated power)" if self.follows_rating else ""
            most = max(self.greatest_torque, 0.0)
            return (
                f"the required point of {point}{follows} is out of reach: this drive delivers at most {most:.3g} N·m "
                f"there{accepted}"
            )
        return (
            f"a torque ripple below {100.0 * self.limit:g} % is required for {point}, but within "
            f"{100.0 * self.tolerance:g} % of the minimum current sum it is at least {100.0 * self.least:.1f} %, at "
            f"{degrees(self.advance):.1f}°{accepted}"
        )

    @property
    def nearest_percent(self) -> int:
        """Limit of the ripple, in whole percent, that every such angle meets with a reserve of 2 %."""
        return _percent_with_reserve(self.greatest) if isfinite(self.greatest) else 0

    def document(self) -> dict[str, object]:
        found = isfinite(self.least)
        return {
            "key": "requirements.ripple_percent" if found else "requirements.point",
            "message": self.sentence(),
            "speed_rpm": self.speed_rpm,
            "torque_nm": self.torque_nm,
            "least_ripple_percent": 100.0 * self.least if found else None,
            "nearest_ripple_percent": self.nearest_percent if found else None,
            "greatest_torque_nm": self.greatest_torque,
            "accepted": [dict(changes) for changes in self.accepted],
        }


def unreachable_ripple(drive: RatedDrive) -> tuple[UnreachableRipple, ...]:
    """Return the required points whose torque or torque ripple no controller can have.

    At a point with too much ripple, every angle that gives the torque with the current sum that `CNV-2` allows has more
    ripple than the limit, even with the ideal regulator. A point's torque is the shaft's, so friction adds to it.
    """
    limits = drive.limits
    found = []
    for point in points_of(drive.document):
        speed = point.speed_rpm * RADIANS_PER_RPM
        least, advance, greatest = _ripples(drive, point)
        if not least < limits.ripple:
            found.append(
                UnreachableRipple(
                    speed_rpm=point.speed_rpm,
                    torque_nm=point.torque_n_m,
                    limit=limits.ripple,
                    least=least,
                    advance=advance,
                    greatest=greatest,
                    tolerance=limits.optimum_tolerance,
                    greatest_torque=oracle.greatest_torque_at_limit(drive.constants, speed).torque
                    - friction_torque(drive.constants, speed),
                    follows_rating=not drive.document.requirements.point,
                )
            )
    return tuple(found)


def machine_torque(drive: RatedDrive, point: RequiredPoint) -> float:
    """Return the torque that the machine needs at a required point: the shaft's and friction (N m)."""
    return point.torque_n_m + friction_torque(drive.constants, point.speed_rpm * RADIANS_PER_RPM)


def ripple_percent_of_all(drive: RatedDrive) -> float:
    """Return the limit that every angle with a current sum that `CNV-2` allows meets at all points (%); NaN if none."""
    found = [0]
    for point in points_of(drive.document):
        *_, greatest = _ripples(drive, point)
        if not isfinite(greatest):
            return nan
        found.append(_percent_with_reserve(greatest))
    return float(max(found))


def _percent_with_reserve(ripple: float) -> int:
    return ceil(102.0 * ripple)


def _ripples(drive: RatedDrive, point: RequiredPoint) -> tuple[float, float, float]:
    """Find the least ripple, its angle and the greatest ripple at the angles with an allowed current sum."""
    speed, torque = point.speed_rpm * RADIANS_PER_RPM, machine_torque(drive, point)
    best = oracle.least_current_sum(drive.constants, speed, torque)
    if not isfinite(best.advance):
        return nan, nan, nan
    allowed = (1.0 + drive.limits.optimum_tolerance) * best.current_sum
    edge = oracle.feasible_edge(drive.ideal, speed, torque)
    # The optimum itself counts, whatever its last digits.
    found = [(_ripple_from_edge(drive, speed, torque, best.advance, edge), best.advance)]
    for direction in (_STEP, -_STEP):
        for step in range(1, _MOST_STEPS):
            advance = best.advance + step * direction
            if advance < 0.0:
                break
            there = oracle.point_at_torque(drive.constants, speed, advance, torque)
            if not there.current_sum <= allowed:
                break
            found.append((_ripple_from_edge(drive, speed, torque, advance, edge), advance))
    least, angle = min(found)
    return least, angle, max(found)[0]


def ideal_ripple(drive: RatedDrive, speed: float, torque: float, advance: float) -> float:
    """Compute the ripple with the ideal regulator at an angle, or at its own feasible edge where that is higher."""
    if not isfinite(advance):
        return nan
    edge = oracle.feasible_edge(drive.ideal, speed, torque)
    return _ripple_from_edge(drive, speed, torque, advance, edge)


def _ripple_from_edge(drive: RatedDrive, speed: float, torque: float, advance: float, edge: float) -> float:
    if not isfinite(edge):
        return nan
    # An optimum on the edge may lie a little below that of the regulator without a band.
    point = oracle.point_at_torque(drive.ideal, speed, max(advance, edge), torque)
    return (point.torque_highest - point.torque_lowest) / point.torque
