"""Reading a measured value off what a figure of a moment draws."""

from __future__ import annotations

import json
import re

import numpy as np
from numpy.typing import NDArray

from drivegate.checks.check import Check, Record
from drivegate.checks.course import DIGITS
from drivegate.checks.margin import Moment
from drivegate.contracts.recorded_trace import closeup_of, deciding_moment
from drivegate_cases.documents.wording import significant

_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
_SAME = 0.02
Line = tuple[NDArray[np.float64], NDArray[np.float64]]


def read_off(check: Check, record: Record) -> tuple[str, list[float]]:
    """Return what a check states of a failing run, and the numbers that can be read off the figure of its moment."""
    margin = check.evaluate(record)
    assert margin is not None, f"{check.id} does not apply to the run"
    assert not margin.met, f"{check.id} is met: {margin.measured}"
    closeup = closeup_of(record, deciding_moment(check, record, margin))
    assert closeup is not None, f"{check.id} has no figure of its own"
    moment = Moment.model_validate_json(json.dumps(closeup["moment"]))
    assert moment.is_marked, f"{check.id} marks nothing in the stretch that it is judged on"
    lines = [(np.array(course.time_s), np.array(course.values)) for course in moment.courses]
    if not lines:
        columns = closeup["columns"]
        lines = [(np.array(columns["time_s"]), np.array(columns[moment.column]))]
    drawn = [
        values[(times >= moment.start_s - 1e-9) & (times <= moment.end_s + 1e-9)] for times, values in lines
    ]
    return margin.measured, _numbers(moment, drawn, _marked(moment, lines))


def _marked(moment: Moment, lines: list[Line]) -> list[float]:
    """Return the value at the ring that marks what was measured, which has to be on a line."""
    point = moment.point
    if point is None:
        return []
    height = max(float(np.ptp(values)) for _, values in lines) or 1.0
    drawn = significant(point.value, DIGITS)
    for times, values in lines:
        near = int(np.argmin(np.abs(times - point.time_s)))
        around = values[max(near - 2, 0) : near + 3]
        if np.min(around) - 0.02 * height <= drawn <= np.max(around) + 0.02 * height:
            return [point.value]
    raise AssertionError(f"the ring at {point} is on no line")


def _numbers(moment: Moment, drawn: list[NDArray[np.float64]], marked: list[float]) -> list[float]:
    """Return ends, distances from the marked lines, the time after the origin, and all that in percent."""
    marks = [level.value for level in moment.levels]
    least, most = (
        min(float(np.min(values)) for values in drawn),
        max(float(np.max(values)) for values in drawn),
    )
    # Of two pairs of extremes, the first pair is that of the run that is judged.
    swing = float(np.max(drawn[0]) - np.min(drawn[1 if len(drawn) > 1 else 0]))
    ends = [least, most, *marked]
    apart = []
    if len(drawn) == 2 and len(drawn[0]) == len(drawn[1]):
        apart.append(float(np.max(np.abs(drawn[0] - drawn[1]) / np.maximum(np.abs(drawn[1]), 1.0))))
    numbers = [*apart, *ends, *marks, swing, most - least, *(end - mark for end in ends for mark in marks)]
    middle = float(np.mean([np.mean(values) for values in drawn]))
    bases = [middle, *marks, *(mark - float(drawn[0][0]) for mark in marks)]
    numbers += [100.0 * number / base for number in numbers for base in bases if base != 0.0]
    if moment.origin_s is not None and moment.point is not None:
        after = moment.point.time_s - moment.origin_s
        numbers += [after, 1e3 * after]
    return numbers


def is_read(measured: str, numbers: list[float]) -> bool:
    """Return True if one of the first two numbers that a check states is among those that can be read."""
    stated = [abs(float(text)) for text in _NUMBER.findall(measured)][:2]
    return any(abs(abs(number) - value) <= _SAME * value + 1e-9 for number in numbers for value in stated)
