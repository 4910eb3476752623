"""The numbers of limits in the texts of checks."""

from dataclasses import dataclass
from math import inf

from drivegate.checks.number_words import limit_words


@dataclass(frozen=True)
class Limits:
    overshoot: float = 0.1
    ripple: float = inf
    torque_error_nm: float = 0.0123456
    speed_tolerance_rpm: float = 15.0
    angle_deg: float = 1.0
    points: tuple[float, ...] = (1.0,)


def test_a_new_limit_has_its_words_by_its_name_and_unit() -> None:
    assert limit_words(Limits()) == {
        "overshoot": "10 %",
        "ripple": "no limit",
        "torque_error": "0.01235 N·m",
        "speed_tolerance": "15 rpm",
        "angle": "1°",
    }
