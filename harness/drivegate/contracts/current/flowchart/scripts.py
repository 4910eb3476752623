"""Scripts that lead a flowchart's search through each of its branches."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

from drivegate.candidates.declaration import FlowchartProfile
from drivegate.scenarios.drive_scale import scale_of
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.scenario import LONGEST_CONTROL_PERIOD_S
from drivegate_cases.scenario.script import Script, ScriptRow

LOWEST_SHARE: Final = 0.025
"""Share of the range above which a speed is one of the fixed scripts; they go down by 4 % (1)."""
MOST_ROWS: Final = 150
"""Greatest length of a script that leads to the end of the range."""
_SUMS_A: Final = (1.0, 1e5)
_LEAST_UNIT, _GREATEST_UNIT = 0.002, 0.02
_DIGITS: Final = 9
_JUST: Final = 1e-4

_WITHIN, _BEYOND = 1.0 - _JUST, 1.0 + _JUST
_FALL, _RISE = -3.0, 3.0


class Event(NamedTuple):
    """What a row changes."""

    power: float
    """Change of the power over k2, negative for a fall (1)."""
    error: float = 0.0
    """Speed error over k1 (1)."""
    speed_rpm: float | None = None
    """Speed from here on (rpm); None where it stays."""


def script_of(
    name: str,
    drive: DriveDocument,
    profile: FlowchartProfile,
    speed_rpm: float,
    events: Sequence[Event],
    why: str = "",
) -> Script:
    """Write a script: a first row from which nothing has changed yet, and one row for each event."""
    falls = sum(abs(event.power) for event in events if event.power < 0.0)
    steps = profile.power_tolerance / drive.inverter.supply_voltage_v
    current = round(scale_of(drive).current_sum_a + falls * steps, 3)
    rows = [_row(speed_rpm, 0.0, current, drive, profile)]
    for event in events:
        changed = _changed(current, event.power, steps, profile.power_tolerance_fraction)
        if not _SUMS_A[0] <= changed <= _SUMS_A[1]:
            changed = _changed(current, -event.power, steps, profile.power_tolerance_fraction)
        current = round(changed, _DIGITS)
        speed_rpm = event.speed_rpm or speed_rpm
        rows.append(_row(speed_rpm, event.error, current, drive, profile))
    return Script(
        kind="script",
        name=name,
        description=why,
        drive=drive,
        control_period_s=control_period(profile),
        rows=tuple(rows),
    )


def control_period(profile: FlowchartProfile) -> float:
    """Return the control period of a script: the longest one that the search's period is a multiple of."""
    return profile.period / math.ceil(profile.period / LONGEST_CONTROL_PERIOD_S - 1e-9)


def _row(
    speed_rpm: float, error: float, current: float, drive: DriveDocument, profile: FlowchartProfile
) -> ScriptRow:
    tolerance = profile.speed_tolerance * 30.0 / math.pi
    requested = round(speed_rpm + error * tolerance, _DIGITS)
    return ScriptRow(
        # Where k1 is greater than the speed, the error can only be upward.
        speed_reference_rpm=requested if requested >= 0.0 else round(speed_rpm - error * tolerance, _DIGITS),
        speed_rpm=speed_rpm,
        current_sum_a=current,
        supply_v=drive.inverter.supply_voltage_v,
    )


def _changed(current: float, power: float, steps: float, fraction: float) -> float:
    """Return the current sum after a change of power by so many k2, of which `steps` and a fraction are one."""
    sign = math.copysign(1.0, power)
    share = min(abs(power), 1.0) * sign
    # k2 is a fraction of the new power, so this is the new one that is just so far away.
    changed = (current + share * steps) / (1.0 - share * fraction)
    unit = max(steps, min(max(fraction, _LEAST_UNIT), _GREATEST_UNIT) * current if not steps else 0.0)
    return changed + max(abs(power) - 1.0, 0.0) * sign * unit


def probe(drive: DriveDocument, profile: FlowchartProfile, speed_rpm: float) -> Script:
    """Write a script on which every flowchart's angle changes, wherever it begins and in whichever direction."""
    powers = (_FALL, _FALL, _RISE, _FALL, _FALL, _FALL, _FALL, _RISE, _FALL)
    return script_of("probe", drive, profile, speed_rpm, [Event(power) for power in powers])


def usual_speed(drive: DriveDocument, speed_range_rpm: tuple[float, float] | None) -> float | None:
    slowest, fastest = speed_range_rpm or (0.0, math.inf)
    scale = scale_of(drive)
    speed = min(max(scale.highest_loaded_rpm, slowest), fastest)
    lowest = scale.base_speed_rpm + LOWEST_SHARE * (scale.highest_loaded_rpm - scale.base_speed_rpm)
    return speed if speed > lowest else None


def fixed_scripts(drive: DriveDocument, profile: FlowchartProfile, speed_rpm: float) -> tuple[Script, ...]:
    """List the scripts that are always run, one for each branch of the flowchart."""
    powers = {
        "fall": ([_FALL] * 6, "W falls again and again: the search goes on."),
        "rise": ([_RISE] * 6, "W rises again and again: every decision reverses the search."),
        "alternate": ([_FALL, _RISE] * 4, "W falls and rises in turn."),
        "within-k2": (
            [_FALL, 0.0, -_WITHIN, -_WITHIN, 0.0, _WITHIN, _WITHIN, _FALL, 0.0, _RISE, 0.0, _FALL],
            "W changes by just less than k2 or not at all between two moves: the search stops, and remembers its "
            "direction.",
        ),
        "beyond-k2": (
            [_FALL, -_BEYOND, -_BEYOND, -_BEYOND, _RISE, _BEYOND, _BEYOND, _BEYOND],
            "W changes by just more than k2.",
        ),
        "to-one-end": (
            [_FALL] * _rows_to_the_end(profile),
            "W falls until the angle is at the end of its range.",
        ),
        "to-the-other-end": (
            [_FALL, _RISE] + [_FALL] * _rows_to_the_end(profile),
            "W rises once and then falls until the angle is at the other end of its range.",
        ),
    }
    scripts = [
        script_of(name, drive, profile, speed_rpm, [Event(power) for power in changes], why)
        for name, (changes, why) in powers.items()
    ]
    errors = (0.0, 0.0, 2.0, 2.0, 0.0, 0.0, -2.0, 0.0, _WITHIN, _BEYOND, -_WITHIN, -_BEYOND, 0.0)
    gate = [Event(_FALL, error) for error in errors]
    gate += [Event(_RISE), Event(_FALL, 2.0), Event(_FALL)]
    speeds = [Event(_FALL, 0.0, speed_rpm * share) for share in (0.99, 0.97, 0.96, 1.0, 0.98)]
    scripts.append(
        script_of(
            "gate", drive, profile, speed_rpm, gate, "The speed is off by more and less than k1 in turn."
        )
    )
    scripts.append(
        script_of(
            "speeds", drive, profile, speed_rpm, speeds, "The speed changes, and its reference with it."
        )
    )
    return tuple(scripts)


def _rows_to_the_end(profile: FlowchartProfile) -> int:
    return min(math.ceil(0.5 * math.pi / profile.step) + 2, MOST_ROWS)
