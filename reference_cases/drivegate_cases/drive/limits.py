"""How the limits of a drive follow from its requirements and its rating, and the times that it needs."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Final, TypeAlias

from drivegate_cases.documents.wording import decimal_exponent, significant
from drivegate_cases.drive.usual_values import DriveValues
from drivegate_models.units import RADIANS_PER_RPM

POINT_POWER_SHARE: Final = 1.02625
"""Power at the required point over rated power, where none is stated: 9.8 N·m at 1500 rpm over 1.5 kW (1)."""
SPEED_TOLERANCE_SHARE: Final = 0.01
"""Speed tolerance k1 over base speed, where none is stated (1)."""
MECHANICAL_TIMES: Final = 11.0
"""Mechanical time constants in a unit of time (1)."""
ELECTRICAL_PERIODS: Final = 91.0
"""Electrical periods at base speed in a unit of time (1)."""
SHORTEST_TIME_UNIT_S: Final = 1.0
"""Whatever the drive, ten of the means over `MEAN_UNITS` by which convergence is judged, of 0.1 s and more (s)."""
MEAN_UNITS: Final = 0.1
"""Units of time over which the means of the current sum are taken: nine electrical periods, and a tenth more (1)."""
_KEPT: Final = 100
_STEPS: Final = ("1", "2", "5")
# Closer to each other: a search that has a third less time than it needs fails.
_STEPS_OF_TIME: Final = ("1", "1.5", "2", "3", "5", "7")

Derive: TypeAlias = Callable[[float, DriveValues], float]
"""From what a key states, and from the drive, to a limit."""


@dataclass(frozen=True)
class Limit:
    """A limit of the checks, declared in the annotation of the key of `[requirements]` that states it."""

    name: str
    """Its name in `Limits`, with the unit at the end; without one it is a share, or as its key where they are equal."""
    of: Derive = lambda stated, _: stated
    """How it follows from the value of the key: by default it is that value."""
    in_texts: str = ""
    """Its name in the texts of checks, where that is not the name without the unit."""
    otherwise: Callable[[DriveValues], float] = lambda _: math.nan
    """How it follows from the drive where its file leaves the key out."""

    def on(self, drive: DriveValues, key: str) -> float:
        """Return the limit of a drive, by its key."""
        stated = getattr(drive.requirements, key)
        return self.otherwise(drive) if stated is None else self.of(stated, drive)


class Limits:
    """What the controllers of a drive are judged by: the number of each `Limit`, by its name."""

    def __init__(self, numbers: Mapping[str, float]) -> None:
        self.__dict__.update(numbers)

    def __getattr__(self, name: str) -> float:
        raise AttributeError(f"no key of the drive's requirements declares a limit {name!r}")


def declared_limits(drive: DriveValues) -> Iterator[tuple[str, Limit]]:
    """List the limits that the keys of a drive's requirements declare, each with its key."""
    for key, field in type(drive.requirements).model_fields.items():
        yield from ((key, limit) for limit in field.metadata if isinstance(limit, Limit))


@lru_cache(maxsize=_KEPT)
def limits_of(drive: DriveValues) -> Limits:
    """Return all limits of a drive; what its file leaves out follows from the drive."""
    return Limits({limit.name: limit.on(drive, key) for key, limit in declared_limits(drive)})


def times(factor: float, base: Callable[[DriveValues], float] = lambda _: 1.0) -> Derive:
    """Make the function from what a key states to a multiple of it, and of a value of the drive."""
    return lambda stated, drive: factor * stated * base(drive)


def share(percent: float, _drive: DriveValues) -> float:
    """Return a share from percent (1)."""
    return percent / 100.0


def ripple_limit(name: str, of_decoupled: float) -> Limit:
    """Make the limit of a torque ripple: where none is stated, that of decoupled phases, and none of a star."""
    return Limit(name, share, otherwise=lambda drive: of_decoupled if drive.has_split_supply else math.inf)


SPEED_TOLERANCE: Final = Limit(
    "speed_tolerance_rpm",
    in_texts="k1",
    otherwise=lambda drive: SPEED_TOLERANCE_SHARE * drive.rating.base_speed_rpm,
)
"""Greatest speed error k1 of a drive of any kind (rpm)."""
SETTLING: Final = Limit("settling_s", otherwise=lambda drive: 6.0 * time_unit(drive))
"""Time in which a search has to converge (s)."""


def time_unit(drive: DriveValues) -> float:
    """Return the unit of the times in which a drive is run: 1 s, or 1.5, 2, 3, 5, 7, 10 s … for one that is slower.

    The speed moves in mechanical time constants, J·ω/T at base speed and rated torque, and currents and torque repeat
    in electrical periods; the slower one rules. A drive that is faster gets no shorter times, since convergence is
    judged by means over 0.1 s, and searches decide no more often.
    """
    return max(nearest_step(ideal_time_unit(drive), _STEPS_OF_TIME), SHORTEST_TIME_UNIT_S)


def ideal_time_unit(drive: DriveValues) -> float:
    """Return the time that `time_unit` rounds to a step (s)."""
    speed = drive.rating.base_speed_rpm * RADIANS_PER_RPM
    electrical = 2.0 * math.pi / (float(drive.machine.pole_pairs) * speed)
    return max(MECHANICAL_TIMES * mechanical_time(drive), ELECTRICAL_PERIODS * electrical)


def mean_time(drive: DriveValues) -> float:
    """Return the time of the means of the current sum by which convergence is judged (s).

    Over fewer electrical periods, the part of one that is left over moves the mean of a current sum that stands still.
    """
    return MEAN_UNITS * time_unit(drive)


def mechanical_time(drive: DriveValues) -> float:
    """Return the time in which rated torque accelerates the shaft to base speed, J·ω/T (s)."""
    speed = drive.rating.base_speed_rpm * RADIANS_PER_RPM
    return float(drive.machine.inertia_kg_m2) * speed * speed / drive.rating.rated_power_w


def nearest_step(value: float, steps: tuple[str, ...] = _STEPS) -> float:
    """Return the nearest of 1, 2, 5 times a power of ten, or of other steps that people read easily; 0 of 0."""
    if value <= 0.0:
        return 0.0
    exponent = decimal_exponent(value)
    nearby = [float(f"{step}e{exponent}") for step in steps] + [float(f"1e{exponent + 1}")]
    return min(nearby, key=lambda step: max(step / value, value / step))


def rounded(value: float, digits: int) -> float:
    """Round to decimals, or to as many significant digits where that would lose what there is."""
    few = round(value, digits)
    return few if abs(few) >= float(f"1e{2 - digits}") else significant(value, digits)
