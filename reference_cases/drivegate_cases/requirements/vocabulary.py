"""The words of a row: events, statistics and units of time, each once, with its meaning."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import pi
from types import MappingProxyType
from typing import Final, Literal, TypeAlias, get_args

from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import limits_of, mechanical_time
from drivegate_models.units import RADIANS_PER_RPM

EventName: TypeAlias = Literal[
    "start",
    "step of reference",
    "step of speed reference",
    "step of torque reference",
    "step of load",
    "step of link",
    "failure",
    "restart",
    "release",
    "loss of a signal",
    "end of a change",
]
StatisticName: TypeAlias = Literal[
    "value", "absolute", "peak", "mean", "rms", "peak to peak", "time until", "sign changes"
]
EVENTS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "start": "the begin of a run",
        "step of reference": "a step of the reference that the controller follows, speed or torque",
        "step of speed reference": "a step of the speed reference, where the controller follows it",
        "step of torque reference": "a step of the torque reference",
        "step of load": "a step of the load's share, or of a vehicle's grade",
        "step of link": "a step of the supply",
        "failure": "what the scenario's failure breaks, or loses, for good",
        "restart": "a reset of the controller while the drive runs on",
        "release": "a dynamometer lets go of the shaft",
        "loss of a signal": "a sensor's signal is lost for a moment",
        "end of a change": "reference, load, link and plant have stopped changing, also after a ramp",
    }
)
"""What can begin a window, with what it means."""
STATISTICS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "value": "every value, with its sign",
        "absolute": "every value, without its sign",
        "peak": "the greatest magnitude",
        "mean": "the mean",
        "rms": "the root mean square",
        "peak to peak": "the greatest value less the least",
        "time until": "the time in seconds from the event until the quantity stays within `until`",
        "sign changes": "how many times the sign changes",
    }
)
"""What a limit is for, with what it means."""
assert tuple(EVENTS) == get_args(EventName)
assert tuple(STATISTICS) == get_args(StatisticName)


@dataclass(frozen=True)
class TimeUnit:
    """A unit of a window's times."""

    words: str
    seconds: Callable[[DriveDocument, float], float]
    """From a drive and a control period (s) to its length (s)."""


TIME_UNITS: Final[Mapping[str, TimeUnit]] = MappingProxyType(
    {
        "s": TimeUnit("s", lambda _drive, _period: 1.0),
        "periods": TimeUnit("control periods", lambda _drive, period: period),
        "settling_times": TimeUnit("settling times", lambda drive, _: float(limits_of(drive).settling_s)),
        "mechanical_times": TimeUnit("mechanical time constants", lambda drive, _: mechanical_time(drive)),
        "electrical_periods": TimeUnit(
            "electrical periods at base speed",
            lambda drive, _: (
                2.0 * pi / (drive.machine.pole_pairs * drive.rating.base_speed_rpm * RADIANS_PER_RPM)
            ),
        ),
    }
)
"""By the ending of the key `between_…` that is in it."""
