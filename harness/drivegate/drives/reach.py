"""Ratings that no controller can meet, each with the nearest ones that can be met."""

from __future__ import annotations

from dataclasses import dataclass
from math import floor, isnan
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from drivegate.drives.bisection import last_met
from drivegate.drives.drive_kind import FloatArray
from drivegate.drives.kinds import DEFAULT_DRIVE
from drivegate.drives.pm_ac_reach import refuse_unreachable_duty
from drivegate.drives.rating import RatedDrive, rated_drive
from drivegate.drives.required_ripple import UnreachableRipple, unreachable_ripple
from drivegate_cases.documents.rounding import significant
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.drive.limits import decimal_exponent, time_unit
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_models.errors import InputError
from drivegate_models.units import RADIANS_PER_RPM

SPEEDS: Final = 21
"""Speeds from the lowest loaded to the highest at which rated power is looked for."""
LONGEST_TIME_UNIT_S: Final = 600.0
"""Longest unit of the times in which a drive is run (s): a search then has an hour to converge."""
_DIGITS: Final = 3
_ROUNDING: Final = 1e-9
_MORE_CURRENT: Final = (1.25, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0)
_HALVINGS: Final = 8
_KILO: Final = 1000.0
_LARGE_TORQUE: Final = 10.0


@dataclass(frozen=True)
class UnreachableRating:
    """Rated power that the drive cannot give at some speed, whatever the angle.

    Attributes
    ----------
    speed : float
        Where most is missing (rad/s).
    rated_power : float
        Rated power (W).
    needed_torque : float
        Torque that it takes there (N·m).
    greatest_torque : float
        Greatest torque that the drive gives there at the current limit (N·m).
    current_limit : float
        The current limit (A).
    lowest_speed, highest_speed : float
        Speeds at which rated power is required (rad/s).
    nearest_power : float
        Power, to three digits, that can be met from the lowest speed to the highest (W); 0 where none can.
    nearest_range : (float, float) or None
        The longest stretch of speeds over which rated power can be met (rad/s).
    nearest_limit : float or None
        Least current limit found, to three digits, at which rated power could be met (A); None up to fifty times
        the present one.
    """

    speed: float
    rated_power: float
    needed_torque: float
    greatest_torque: float
    current_limit: float
    lowest_speed: float
    highest_speed: float
    nearest_power: float
    nearest_range: tuple[float, float] | None
    nearest_limit: float | None

    def sentence(self) -> str:
        """Tell what is out of reach, and what is not."""
        given = max(self.greatest_torque, 0.0)
        return (
            f"{power_in_words(self.rated_power)} needs {_torque(self.needed_torque)} N·m at {_rpm(self.speed)} rpm; "
            f"at the current limit of {self.current_limit:g} A this drive gives {_torque(given)} N·m "
            f"({power_in_words(given * self.speed)}) at best; {self._nearest()}"
        )

    def _nearest(self) -> str:
        ways = []
        if self.nearest_power > 0.0:
            whole = f"from {_rpm(self.lowest_speed)} to {_rpm(self.highest_speed)} rpm"
            ways.append(f"{power_in_words(self.nearest_power)} {whole}")
        if self.nearest_range is not None:
            low, high = self.nearest_range
            ways.append(f"{power_in_words(self.rated_power)} from {_rpm(low)} to {_rpm(high)} rpm")
        if self.nearest_limit is not None:
            ways.append(f"all of it with a current limit of {self.nearest_limit:g} A")
        met = f"what can be met is {', or '.join(ways)}" if ways else "no power can be met"
        return met if self.nearest_limit is not None else f"{met}; more current alone would not help"

    def document(self) -> dict[str, object]:
        """Give what is out of reach as plain data, in people's units."""
        stretch = self.nearest_range
        return {
            "key": "rated_power_w",
            "message": self.sentence(),
            "speed_rpm": self.speed / RADIANS_PER_RPM,
            "needed_torque_nm": self.needed_torque,
            "greatest_torque_nm": self.greatest_torque,
            "nearest_power_w": self.nearest_power,
            "nearest_range_rpm": None if stretch is None else [speed / RADIANS_PER_RPM for speed in stretch],
            "nearest_limit_a": self.nearest_limit,
        }


Unreachable: TypeAlias = UnreachableRating | UnreachableRipple
"""What no controller can meet, with a sentence about it."""


def power_in_words(power: float) -> str:
    """Write a power to three digits."""
    return f"{power / _KILO:.3g} kW" if power >= _KILO else f"{power:.3g} W"


def unreachable_ratings(drive: RatedDrive) -> tuple[UnreachableRating, ...]:
    """Find the ratings that no controller can meet.

    Parameters
    ----------
    drive : RatedDrive
        The drive with its rating.

    Returns
    -------
    tuple of UnreachableRating
        Rated power, where at one of `SPEEDS` speeds from the lowest loaded to the highest no angle gives its torque at
        the current limit; empty where all can be met.
    """
    speeds = _speeds(drive)
    greatest = _greatest(drive)
    needed = np.array([drive.demanded_torque(float(speed)) for speed in speeds])
    missing = greatest - needed
    if (missing >= 0.0).all():
        return ()
    worst = int(np.argmin(greatest / needed))
    # What the shaft loses on the way is no power, and does not shrink with the rating.
    spare = np.min((greatest - needed) * speeds) + drive.rating.power
    return (
        UnreachableRating(
            speed=float(speeds[worst]),
            rated_power=drive.rating.power,
            needed_torque=float(needed[worst]),
            greatest_torque=float(greatest[worst]),
            current_limit=float(drive.constants.current_limit),
            lowest_speed=drive.rating.lowest_speed,
            highest_speed=drive.rating.highest_speed,
            nearest_power=_rounded(float(spare), up=False),
            nearest_range=_longest_stretch(missing >= 0.0, speeds),
            nearest_limit=_sufficient_limit(drive),
        ),
    )


def unreachable(drive: RatedDrive) -> tuple[Unreachable, ...]:
    """Find all of a drive's rating and requirements that no controller can meet."""
    return (*unreachable_ratings(drive), *unreachable_ripple(drive))


def refuse_unreachable(document: DriveDocument) -> None:
    """Refuse a drive whose rating or requirements no controller can meet: no candidate is to be failed for it."""
    if document == load_drive(DEFAULT_DRIVE):
        return
    if isinstance(document, PmAcDocument):
        refuse_unreachable_duty(document)
        return
    if (unit := time_unit(document)) > LONGEST_TIME_UNIT_S:
        raise InputError(
            f"the drive '{document.name}' is too slow to be checked: it takes {unit:g} s from change to change, "
            f"and at most {LONGEST_TIME_UNIT_S:g} s are taken; its inertia_kg_m2 is "
            f"{document.machine.inertia_kg_m2:g}, its rated power {document.rating.rated_power_w:g} W"
        )
    for found in unreachable(rated_drive(document)):
        raise InputError(
            f"no controller can meet what the drive '{document.name}' requires: {found.sentence()}"
        )


def _speeds(drive: RatedDrive) -> FloatArray:
    return np.linspace(drive.rating.lowest_speed, drive.rating.highest_speed, SPEEDS)


def _greatest(drive: RatedDrive) -> FloatArray:
    find, constants = drive.oracle.greatest_torque_at_limit, drive.constants
    return np.array([find(constants, float(speed)).torque for speed in _speeds(drive)])


def rating_is_met(drive: RatedDrive) -> bool:
    """Tell whether the drive gives rated power at every speed at which it is required."""
    return all(
        drive.oracle.greatest_torque_at_limit(drive.constants, float(speed)).torque
        >= drive.demanded_torque(float(speed))
        for speed in _speeds(drive)
    )


def _longest_stretch(met: NDArray[np.bool_], speeds: FloatArray) -> tuple[float, float] | None:
    """Give the first and last speed of the longest run of speeds that are met, of two at least."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], met, [False])).astype(int)))
    stretches = [(int(first), int(last) - 1) for first, last in edges.reshape(-1, 2)]
    first, last = max(stretches, key=lambda stretch: stretch[1] - stretch[0], default=(0, 0))
    return (float(speeds[first]), float(speeds[last])) if last > first else None


def _sufficient_limit(drive: RatedDrive) -> float | None:
    """Find a current limit at which rated power can be met, by halving between one that is and one that is not."""
    limit = float(drive.constants.current_limit)
    low = limit
    for factor in _MORE_CURRENT:
        high = factor * limit
        if rating_is_met(drive.limited_to(high)):
            break
        low = high
    else:
        return None
    least = last_met(lambda tried: rating_is_met(drive.limited_to(tried)), high, low, _HALVINGS)
    rounded = _rounded(least, up=True)
    return rounded if rating_is_met(drive.limited_to(rounded)) else least


def _rounded(value: float, *, up: bool) -> float:
    """Round to three digits, up or down."""
    if value <= 0.0 or isnan(value):
        return 0.0
    unit = float(f"1e{decimal_exponent(value) - _DIGITS + 1}")
    whole = floor(value / unit * (1.0 + (-_ROUNDING if up else _ROUNDING))) + (1 if up else 0)
    return significant(whole * unit, _DIGITS)


def _rpm(speed: float) -> str:
    return f"{speed / RADIANS_PER_RPM:.4g}"


def _torque(torque: float) -> str:
    """Write a torque to a tenth, and to three digits where it is small."""
    return f"{torque:.1f}" if torque >= _LARGE_TORQUE else f"{torque:#.3g}"
