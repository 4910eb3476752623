"""Rated power that no controller can deliver, with the values of the rating that a check accepts instead."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate.drives.constant_power import last_met
from drivegate_cases.documents.wording import rounded_to_digits
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_models.errors import InputError
from drivegate_models.units import RADIANS_PER_RPM

_LEAST_POWER: Final = 0.9
"""Power, over that which the speeds leave, down to which a lower one is tried for what else is required (1)."""
_MORE_CURRENT: Final = (1.25, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0)
_HALVINGS: Final = 8
_KILO: Final = 1000.0
_LARGE_TORQUE: Final = 10.0


@dataclass(frozen=True)
class PowerReach:
    """Rated power over speed, and what a drive can deliver of it."""

    speeds: NDArray[np.float64]
    """Speeds at which rated power is required, rising (rad/s)."""
    needed: NDArray[np.float64]
    """Torque that it needs at each (N·m)."""
    greatest: NDArray[np.float64]
    """Greatest torque that the drive delivers at each, less what is reserved for the regulator (N·m)."""
    reserve: float = 0.0
    """Share of the torque that is reserved (1)."""

    @property
    def is_met(self) -> bool:
        return bool((self.greatest >= self.needed).all())


@dataclass(frozen=True)
class UnreachableRating:
    """Rated power that the drive cannot deliver at some speed, whatever its controller does."""

    speed: float
    """Where most is missing (rad/s)."""
    rated_power: float
    needed_torque: float
    """Torque that it needs there (N·m)."""
    greatest_torque: float
    """Greatest torque that the drive delivers there at the current limit (N·m)."""
    current_limit: float
    reserve: float
    """Share of the torque that is reserved for the regulator (1)."""
    nearest_power: float
    """Power, to three digits, that a check accepts over the same speeds (W); 0 where it accepts none."""
    nearest_range: tuple[float, float] | None
    """The longest stretch of speeds over which rated power can be met (rad/s)."""
    nearest_limit: float | None
    """Least current limit found, to three digits, that a check accepts (A); None up to fifty times the
    present one, or to the peak current that the drive states."""
    nearest_speeds: Mapping[str, float]
    """Speeds of the rating that a check accepts with the same power, by their keys (rpm); empty where none
    were found."""

    @property
    def accepted(self) -> tuple[Mapping[str, float], ...]:
        """Changes that a check accepts, each with its keys and values; the first is the usual one."""
        power = {"rated_power_w": self.nearest_power} if self.nearest_power > 0.0 else {}
        limit = {} if self.nearest_limit is None else {"current_limit_a": self.nearest_limit}
        return tuple(changes for changes in (power, limit, self.nearest_speeds) if changes)

    def sentence(self) -> str:
        most = max(self.greatest_torque, 0.0)
        ways = [setting_words(changes) for changes in self.accepted]
        met = f"a check accepts {', or '.join(ways)}" if ways else "no power can be met"
        useless = "; more current alone would not help" if self.nearest_limit is None else ""
        reserved = f", with {100.0 * self.reserve:.2g} % reserved for the regulator" if self.reserve else ""
        return (
            f"{power_in_words(self.rated_power)} needs {_torque(self.needed_torque)} N·m at "
            f"{self.speed / RADIANS_PER_RPM:.4g} rpm, but at the current limit of {self.current_limit:g} A this drive "
            f"delivers at most {_torque(most)} N·m ({power_in_words(most * self.speed)}) there"
            f"{reserved}; {met}{useless}"
        )

    def document(self) -> dict[str, object]:
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
            "accepted": [dict(changes) for changes in self.accepted],
        }


def setting_words(changes: Mapping[str, float]) -> str:
    """Write changes of keys as a drive's file has them."""
    return " with ".join(f"{key} = {value:g}" for key, value in changes.items())


def power_in_words(power: float) -> str:
    """Write a power to three digits."""
    return f"{power / _KILO:.3g} kW" if power >= _KILO else f"{power:.3g} W"


def unreachable_power(
    document: DriveDocument,
    reach_of: Callable[[DriveDocument], PowerReach],
    is_accepted: Callable[[DriveDocument], bool],
) -> UnreachableRating | None:
    """Return where most torque for rated power is missing, with the nearest ratings that are accepted; None if nowhere.

    `reach_of` returns what a drive can deliver of its rated power, `is_accepted` whether a check accepts its rating.
    """
    reach = reach_of(document)
    if reach.is_met:
        return None

    def accepts(**changes: float) -> bool:
        try:
            return is_accepted(document.replaced(**changes))
        except InputError:
            # The change contradicts another value of the file, such as its peak current.
            return False

    rating = document.rating
    worst = int(np.argmin(reach.greatest / reach.needed))
    # What the shaft loses on the way is no power, and does not shrink with the rating.
    spare = float(np.min((reach.greatest - reach.needed) * reach.speeds)) + rating.rated_power_w
    stretch = _longest_stretch(reach)
    return UnreachableRating(
        speed=float(reach.speeds[worst]),
        rated_power=rating.rated_power_w,
        needed_torque=float(reach.needed[worst]),
        greatest_torque=float(reach.greatest[worst]),
        current_limit=rating.current_limit_a,
        reserve=reach.reserve,
        nearest_power=_sufficient_power(spare, lambda power: accepts(rated_power_w=power)),
        nearest_range=stretch,
        nearest_limit=_sufficient_limit(rating.current_limit_a, lambda limit: accepts(current_limit_a=limit)),
        nearest_speeds=_sufficient_speeds(document, reach, stretch, accepts),
    )


def _longest_stretch(reach: PowerReach) -> tuple[float, float] | None:
    """Return the first and last speed of the longest run of speeds that are met, of two at least."""
    met: NDArray[np.bool_] = reach.greatest >= reach.needed
    edges = np.flatnonzero(np.diff(np.concatenate(([False], met, [False])).astype(int)))
    stretches = [(int(first), int(last) - 1) for first, last in edges.reshape(-1, 2)]
    first, last = max(stretches, key=lambda stretch: stretch[1] - stretch[0], default=(0, 0))
    return (float(reach.speeds[first]), float(reach.speeds[last])) if last > first else None


def _sufficient_power(spare: float, suffices: Callable[[float], bool]) -> float:
    """Find a power to three digits that is accepted, at most what the speeds leave; 0 where none is found."""
    most, least = (rounded_to_digits(share * spare, up=False) for share in (1.0, _LEAST_POWER))
    if most == 0.0 or suffices(most):
        return most
    if not suffices(least):
        return 0.0
    return rounded_to_digits(last_met(suffices, least, most, _HALVINGS), up=False)


def _sufficient_limit(limit: float, suffices: Callable[[float], bool]) -> float | None:
    """Find a current limit that is accepted, by halving between one that is and one that is not."""
    low = limit
    for factor in _MORE_CURRENT:
        high = factor * limit
        if suffices(high):
            break
        low = high
    else:
        return None
    least = last_met(suffices, high, low, _HALVINGS)
    rounded = rounded_to_digits(least, up=True)
    return rounded if suffices(rounded) else least


def _sufficient_speeds(
    document: DriveDocument,
    reach: PowerReach,
    stretch: tuple[float, float] | None,
    accepts: Callable[..., bool],
) -> dict[str, float]:
    """Find the speeds of the rating over which rated power is accepted, from the longest stretch where it is met."""
    if stretch is None:
        return {}
    base, changes = document.rating.base_speed_rpm, {}
    if stretch[0] > reach.speeds[0]:
        # The first speed that is loaded is above base speed by the same share afterwards.
        share = base * RADIANS_PER_RPM / float(reach.speeds[0])
        changes["base_speed_rpm"] = rounded_to_digits(share * stretch[0] / RADIANS_PER_RPM, up=True)
    if stretch[1] < reach.speeds[-1]:
        changes["highest_speed_rpm"] = rounded_to_digits(stretch[1] / RADIANS_PER_RPM, up=False)
    return changes if accepts(**changes) else {}


def _torque(torque: float) -> str:
    """Write a torque to a tenth, and to three digits where it is small."""
    return f"{torque:.1f}" if torque >= _LARGE_TORQUE else f"{torque:#.3g}"
