"""What a drive whose controllers answer with an advance angle can do, and that in sentences."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from math import inf, isfinite
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.declaration import NOTHING_DECLARED
from drivegate.contracts.current.numbers import numbers as drive_numbers
from drivegate.drives.ability import Ability, RunTime
from drivegate.drives.constant_power import ConstantPower, constant_power
from drivegate.drives.envelope import recommended_line, speed_point, speeds_of
from drivegate.drives.envelope_document import envelope_document
from drivegate.drives.power_reach import PowerReach
from drivegate.drives.rating import RatedDrive, rated_drive
from drivegate.drives.required_ripple import UnreachableRipple, machine_torque, unreachable_ripple
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import ideal_time_unit, limits_of, time_unit
from drivegate_cases.drive.requirements import points_of
from drivegate_models.steady import oracle
from drivegate_models.units import RADIANS_PER_RPM

_NO_BAND: Final = (
    "the band is so narrow that it is taken as none, which the means do not show; a check computes each chop, and "
    "takes long"
)
SPEEDS: Final = 21
"""Speeds from the lowest loaded to the highest at which rated power is looked for."""
LONGEST_TIME_UNIT_S: Final = 600.0
"""Longest unit of the times in which a drive is run (s): a search then has an hour to converge."""
_LONGEST_STEP_S: Final = 500.0
"""The longest unit up to `LONGEST_TIME_UNIT_S` among the steps of that unit (s)."""


def facts(document: Mapping[str, Any]) -> list[str]:
    """Describe the line of initial angles, where rated torque needs none or is lacking, and the times."""
    return [
        _line(document),
        _without_advance(document),
        *_out_of_reach(document),
        _times(document),
        _meaning(document),
        *([] if document["has_band"] else [_NO_BAND]),
    ]


def required(drive: DriveDocument) -> list[str]:
    numbers = drive_numbers(drive, NOTHING_DECLARED)
    return [
        "required of a search: from {settling} after a change on the speed stays within {k1} (k1), Σ|i| within {k2} "
        "(k2) and the angle within {angle}; Σ|i| at most {optimum} above the least".format_map(numbers),
        _required_of_torque(drive).format_map(numbers),
    ]


def _required_of_torque(drive: DriveDocument) -> str:
    limits = limits_of(drive)
    required = []
    if isfinite(limits.ripple):
        required.append("a ripple below {ripple} with the ideal regulator at {points}")
    if isfinite(limits.closed_loop_ripple):
        required.append("a ripple below {closed_loop_ripple} in the closed loop")
    return f"required of the torque: {', and '.join(required) or 'nothing, since no limit of its ripple is stated'}"


def _line(document: Mapping[str, Any]) -> str:
    line, base = document["line"], document["rating"]["base_speed_rpm"]
    if line["least_in_hand_percent"] is None:
        return "line of initial angles: none, since rated power is out of reach at every speed"
    in_hand, where = line["least_in_hand_percent"], line["least_in_hand_at_rpm"]
    least = (
        f"it leaves the least torque in hand at {where:g} rpm, {in_hand:.1f} %"
        if in_hand >= 0.0
        else f"it misses rated torque most at {where:g} rpm, by {-in_hand:.1f} %"
    )
    return (
        f"line of initial angles: 0° below {base:g} rpm, then {line['start_deg']:.1f}° + "
        f"{line['slope_deg_per_rpm']:.3g}° per rpm above; {least}"
    )


def _without_advance(document: Mapping[str, Any]) -> str:
    highest = document["rated_torque_without_advance_up_to_rpm"]
    base = document["rating"]["base_speed_rpm"]
    where = "at no speed" if highest is None else f"up to {highest:.0f} rpm"
    return f"rated torque without advance: {where}; base speed is {base:g} rpm"


def _out_of_reach(document: Mapping[str, Any]) -> list[str]:
    """State where the drive lacks rated torque up to base speed, where candidates are not asked for all of it."""
    base = document["rating"]["base_speed_rpm"]
    lacking = [
        point
        for point in document["points"]
        if point["speed_rpm"] <= base and point["greatest_torque_nm"] < point["rated_torque_nm"]
    ]
    if not lacking:
        return []
    worst = min(lacking, key=lambda point: float(point["greatest_torque_nm"]))
    return [
        f"rated torque is out of reach at {worst['speed_rpm']:g} rpm, where the current limit leaves "
        f"{worst['greatest_torque_nm']:.4g} of {worst['rated_torque_nm']:.4g} N·m; candidates are asked for "
        "rated power above base speed alone"
    ]


def _times(document: Mapping[str, Any]) -> str:
    times = {key: _seconds(value) for key, value in document["time_scales"].items() if key.endswith("_s")}
    return (
        f"times: L/R {times['electrical_s']}, current up to its limit {times['current_rise_s']}, "
        f"J·ω/T {times['mechanical_at_base_s']} at base speed and {times['mechanical_at_highest_s']} at the highest, "
        f"base to highest speed with rated power {times['run_up_s']}"
    )


def _meaning(document: Mapping[str, Any]) -> str:
    scales = document["time_scales"]
    half_cycle, drift = scales["half_cycle_s"], scales["drift_s"]
    reason = (
        "half an electrical cycle at highest speed"
        if half_cycle <= drift
        else "in which a lost rated torque costs 1 % of base speed"
    )
    search = scales["search_s"]
    settling = (
        ""
        if search is None or search != search
        else f"; a search from the line to the least Σ|i| takes about {_seconds(search)}, "
        f"{_seconds(scales['decision_s'])} a decision"
    )
    return (
        f"control period: {scales['electrical_frequency_hz']:.3g} Hz at highest speed, so at most "
        f"{_seconds(scales['largest_control_period_s'])}, {reason}{settling}"
    )


def _seconds(value: float | None) -> str:
    # A result writes null for it.
    if value is None or value == inf:
        return "endless"
    return f"{value:.3g} s" if value >= 1.0 else f"{1e3 * value:.3g} ms"


def rating_is_met(drive: RatedDrive) -> bool:
    """Return True if the drive delivers rated power at every speed at which it is required."""
    return all(_greatest(drive, speed) >= drive.demanded_torque(speed) for speed in _speeds(drive).tolist())


def _speeds(drive: RatedDrive) -> NDArray[np.float64]:
    return np.linspace(drive.rating.lowest_speed, drive.rating.highest_speed, SPEEDS)


def _greatest(drive: RatedDrive, speed: float) -> float:
    return oracle.greatest_torque_at_limit(drive.constants, speed).torque


class _AngleAbility(Ability):
    facts = staticmethod(facts)
    required = staticmethod(required)

    def run_time(self, document: DriveDocument) -> RunTime:
        share = _LONGEST_STEP_S / ideal_time_unit(document)
        return RunTime(time_unit(document), LONGEST_TIME_UNIT_S, "from change to change", share)

    def reach(self, document: DriveDocument) -> PowerReach:
        drive = rated_drive(document)
        speeds = _speeds(drive)
        return PowerReach(
            speeds=speeds,
            needed=np.array([drive.demanded_torque(speed) for speed in speeds.tolist()]),
            greatest=np.array([_greatest(drive, speed) for speed in speeds.tolist()]),
        )

    def accepts(self, document: DriveDocument) -> bool:
        """Return True if rated power can be met, and the torque at a required point that follows from it."""
        drive = rated_drive(document)
        if not rating_is_met(drive):
            return False
        # A stated point is refused by itself.
        points = () if document.requirements.point else points_of(document)
        find = partial(oracle.least_current_sum, drive.constants)
        return all(
            isfinite(find(point.speed_rpm * RADIANS_PER_RPM, machine_torque(drive, point)).advance)
            for point in points
        )

    def envelope(self, document: DriveDocument, report: Callable[[int], None]) -> dict[str, Any]:
        drive = rated_drive(document)
        line = recommended_line(drive)
        points = []
        for speed in speeds_of(drive.rating):
            points.append(speed_point(drive, line, speed))
            report(len(points))
        return envelope_document(drive, line, points)

    def unmet(self, document: DriveDocument) -> tuple[UnreachableRipple, ...]:
        return unreachable_ripple(rated_drive(document))

    def constant_power(self, document: DriveDocument) -> ConstantPower:
        return constant_power(rated_drive(document))

    def speeds(self, document: DriveDocument) -> tuple[float, ...]:
        return speeds_of(rated_drive(document).rating)


ANGLE_ABILITY: Final = _AngleAbility()
