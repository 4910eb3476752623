"""What a check refuses of a drive, with the values that it accepts instead."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Final, TypeAlias

import numpy as np

from drivegate.contracts.duty.scenarios.windows import run_up_s
from drivegate.drives.drive_kind import FloatArray
from drivegate.drives.kinds import DEFAULT_DRIVE
from drivegate.drives.pm_ac_reach import unreachable_duty
from drivegate.drives.power_reach import (
    PowerReach,
    UnreachableRating,
    setting_words,
    unreachable_power,
)
from drivegate.drives.rating import RatedDrive, rated_drive
from drivegate.drives.required_ripple import UnreachableRipple, unreachable_ripple
from drivegate_cases.documents.rounding import rounded_to_digits
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.drive.limits import time_unit, wanted_time_unit
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_models.errors import InputError
from drivegate_models.units import RADIANS_PER_RPM

SPEEDS: Final = 21
"""Speeds from the lowest loaded to the highest at which rated power is looked for."""
LONGEST_TIME_UNIT_S: Final = 600.0
"""Longest unit of the times in which a drive is run (s): a search then has an hour to converge."""
LONGEST_RUN_UP_S: Final = 60.0
"""Longest time of a free shaft of a PM AC drive to its highest speed (s): runs are longer than that several times."""
_LONGEST_STEP_S: Final = 500.0
"""The longest unit up to `LONGEST_TIME_UNIT_S` among the steps of that unit (s)."""


@dataclass(frozen=True)
class TooSlow:
    """A drive whose runs would take too long."""

    time: float
    """Time that it needs (s)."""
    longest: float
    """Longest time that is accepted (s)."""
    until: str
    """What happens in that time, in words."""
    change: Mapping[str, float]
    """A value that a check accepts, by its key."""

    @property
    def accepted(self) -> tuple[Mapping[str, float], ...]:
        """The change that a check accepts."""
        return (self.change,)

    def sentence(self) -> str:
        """Return what takes too long, and the value that a check accepts."""
        return (
            f"it needs {self.time:.3g} s {self.until}, but must need at most {self.longest:g} s; a check accepts "
            f"{setting_words(self.change)}"
        )

    def document(self) -> dict[str, object]:
        """Return the same as plain data."""
        return {
            "key": next(iter(self.change)),
            "message": self.sentence(),
            "needed_time_s": self.time,
            "longest_time_s": self.longest,
            "accepted": [dict(self.change)],
        }


Refusal: TypeAlias = TooSlow | UnreachableRating | UnreachableRipple
"""A reason why a check refuses a drive, with a sentence about it."""


def unreachable_ratings(drive: RatedDrive) -> tuple[UnreachableRating, ...]:
    """Find the ratings that no controller can meet.

    Parameters
    ----------
    drive : RatedDrive
        The drive with its rating.

    Returns
    -------
    tuple of UnreachableRating
        Rated power, where at one of `SPEEDS` speeds from the lowest loaded to the highest no angle produces its torque
        at the current limit; empty where all can be met.
    """
    found = unreachable_power(
        drive.document,
        lambda document: _reach(rated_drive(document)),
        lambda document: _accepts(rated_drive(document)),
    )
    return () if found is None else (found,)


def unreachable(drive: RatedDrive) -> tuple[UnreachableRating | UnreachableRipple, ...]:
    """Find all of a drive's rating and requirements that no controller can meet."""
    return (*unreachable_ratings(drive), *unreachable_ripple(drive))


def refusals(document: DriveDocument) -> tuple[Refusal, ...]:
    """Find every reason why a check refuses a drive.

    Parameters
    ----------
    document : DriveDocument
        The drive.

    Returns
    -------
    tuple of Refusal
        That it is too slow, and its rating and requirements that no controller can meet; empty where a check accepts
        the drive.
    """
    slow = _too_slow(document)
    missed: Sequence[Refusal | None] = (
        (unreachable_duty(document),)
        if isinstance(document, PmAcDocument)
        else unreachable(rated_drive(document))
    )
    return tuple(found for found in (slow, *missed) if found is not None)


def refuse_unreachable(document: DriveDocument) -> None:
    """Refuse a drive whose rating or requirements no controller can meet: no candidate is to be failed for it."""
    if document == load_drive(DEFAULT_DRIVE):
        return
    for found in refusals(document):
        if isinstance(found, TooSlow):
            raise InputError(f"the drive '{document.name}' is too slow to be checked: {found.sentence()}")
        raise InputError(
            f"no controller can meet what the drive '{document.name}' requires: {found.sentence()}"
        )


def _too_slow(document: DriveDocument) -> TooSlow | None:
    time, longest = _times(document)
    if time <= longest:
        return None
    if isinstance(document, PmAcDocument):
        until, share = "to its highest speed", longest / time
    else:
        until, share = "from change to change", _LONGEST_STEP_S / wanted_time_unit(document)
    lighter = {"inertia_kg_m2": rounded_to_digits(share * document.machine.inertia_kg_m2, up=False)}
    faster = {"base_speed_rpm": rounded_to_digits(document.rating.base_speed_rpm / share, up=True)}
    lighter_time, _ = _times(document.replaced(**lighter))
    return TooSlow(time, longest, until, lighter if lighter_time <= longest else faster)


def _times(document: DriveDocument) -> tuple[float, float]:
    """Return the time by which runs are measured, and the longest that is accepted (s)."""
    if isinstance(document, PmAcDocument):
        return run_up_s(document, document.rating.highest_speed_rpm), LONGEST_RUN_UP_S
    return time_unit(document), LONGEST_TIME_UNIT_S


def _speeds(drive: RatedDrive) -> FloatArray:
    return np.linspace(drive.rating.lowest_speed, drive.rating.highest_speed, SPEEDS)


def _reach(drive: RatedDrive) -> PowerReach:
    find, speeds = drive.oracle.greatest_torque_at_limit, _speeds(drive)
    return PowerReach(
        speeds=speeds,
        needed=np.array([drive.demanded_torque(float(speed)) for speed in speeds]),
        greatest=np.array([find(drive.constants, float(speed)).torque for speed in speeds]),
    )


def _accepts(drive: RatedDrive) -> bool:
    """Return True if rated power can be met, and the torque at a required point that follows from it."""
    if not rating_is_met(drive):
        return False
    # A stated point is refused by itself.
    points = () if drive.document.requirements.point else drive.limits.points
    find = drive.oracle.least_current_sum
    return all(
        isfinite(find(drive.constants, point.speed_rpm * RADIANS_PER_RPM, point.torque_n_m).advance)
        for point in points
    )


def rating_is_met(drive: RatedDrive) -> bool:
    """Return True if the drive delivers rated power at every speed at which it is required."""
    return all(
        drive.oracle.greatest_torque_at_limit(drive.constants, float(speed)).torque
        >= drive.demanded_torque(float(speed))
        for speed in _speeds(drive)
    )
