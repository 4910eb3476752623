"""The numbers of limits in the texts of checks."""

from math import inf
from types import SimpleNamespace
from typing import Annotated, Any

from drivegate.checks.number_words import limit_words
from drivegate_cases.documents.document import Section
from drivegate_cases.drive.limits import Limit, share


class Requirements(Section):
    overshoot_percent: Annotated[float, Limit("overshoot", share)] = 10.0
    ripple_percent: Annotated[float | None, Limit("ripple", share, otherwise=lambda _: inf)] = None
    torque_error_percent: Annotated[
        float, Limit("torque_error_nm", lambda _, drive: float(drive.machine))
    ] = 2.0
    speed_tolerance_rpm: Annotated[float, Limit("speed_tolerance_rpm", in_texts="k1")] = 15.0
    angle_deg: Annotated[float, Limit("angle_deg")] = 1.0
    swing: Annotated[float, Limit("swing")] = 1.25
    points: tuple[float, ...] = (1.0,)


def test_a_new_limit_has_its_words_by_its_name_and_unit() -> None:
    drive: Any = SimpleNamespace(requirements=Requirements(), machine=0.0123456)
    assert limit_words(drive) == {
        "overshoot": "10 %",
        "ripple": "no limit",
        "torque_error": "0.01235 N·m",
        "k1": "15 rpm",
        "angle": "1°",
        "swing": "1.25",
    }
