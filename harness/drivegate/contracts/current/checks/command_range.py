"""Checks of the commands' ranges: advance angle and current reference."""

from __future__ import annotations

import math

import numpy as np

from drivegate.checks.check import Check
from drivegate.checks.margin import GREATEST, Margin, Mark, Moment, Point, normalised
from drivegate.contracts.current.checks.declared_speeds import below_base, unless_speeds
from drivegate.contracts.current.checks.shown import SHOWN_PERIODS, around
from drivegate.contracts.current.record import CurrentRecord

LARGEST_ANGLE = math.pi / 2.0
"""Greatest advance angle of the contract (rad electrical)."""


def angle_below_base(record: CurrentRecord) -> Margin | None:
    """Judge the advance angle in steps whose own Sense shows less than base speed (paper, Fig. 3)."""
    run = record.run.observed
    if run.steps_below_base == 0.0:
        return None
    angle = run.angle_below_base
    if angle == 0.0:
        return Margin("ADV-1", 1.0, "0° throughout")
    measured = f"{_in_words(angle, 3)} at {run.first_below_base:.4g} s"
    return Margin("ADV-1", normalised(-math.degrees(angle), 1.0), measured)


def angle_range(record: CurrentRecord) -> Margin:
    lowest = record.run.observed.angle_lowest
    highest = record.run.observed.angle_highest
    value = normalised(min(lowest, LARGEST_ANGLE - highest), LARGEST_ANGLE)
    return Margin("ADV-2", value, f"{_in_words(lowest, 4)} to {_in_words(highest, 4)}")


def below_base_moment(record: CurrentRecord) -> Moment | None:
    """Show the advance angle around the first step below base speed that has one."""
    run = record.run.observed
    if run.steps_below_base == 0.0 or run.angle_below_base == 0.0:
        return None
    times = record.run.trace["time_s"]
    place = min(int(np.searchsorted(times, run.first_below_base)), len(times) - 1)
    if record.steps is None:
        return _moment(record, "advance_deg", place, "°", (0.0,))
    angles = np.degrees(record.steps["command"]["advance_angle"][: len(times)])
    values = np.clip(angles, -GREATEST, GREATEST)
    words, quantity = f"{values[place]:.4g}°", "commanded advance angle (°)"
    return around(times, place, [("advance angle", values)], quantity, (("limit 0°", 0.0),), words)


def angle_moment(record: CurrentRecord) -> Moment:
    """Show the advance angle where it comes nearest to an end of its range, or leaves it furthest."""
    degree = math.degrees(1.0)
    return _furthest(record, "advance_angle", degree, "advance_deg", "°", math.degrees(LARGEST_ANGLE))


def reference_moment(record: CurrentRecord) -> Moment:
    """Show the current reference where it comes nearest to an end of its range, or leaves it furthest."""
    limit = record.scenario.drive.rating.current_limit_a
    return _furthest(record, "current_reference", 1.0, "current_reference_a", " A", limit)


def _furthest(
    record: CurrentRecord, field: str, factor: float, column: str, unit: str, highest: float
) -> Moment:
    """Show a field of the commands where they were kept, before any clamping, else the column that was applied."""
    values, kept = record.run.trace[column], record.steps
    if kept is not None:
        values = np.clip(factor * kept["command"][field][: len(values)], -GREATEST, GREATEST)
    place = int(np.argmin(np.minimum(values, highest - values)))
    if kept is None:
        return _moment(record, column, place, unit, (0.0, highest))
    levels = [(f"limit {limit:.4g}{unit}", limit) for limit in (0.0, highest)]
    name = field.replace("_", " ")
    words, quantity = f"{values[place]:.4g}{unit}", f"commanded {name} ({unit.strip()})"
    return around(record.run.trace["time_s"], place, [(name, values)], quantity, levels, words)


def _moment(record: CurrentRecord, column: str, place: int, unit: str, limits: tuple[float, ...]) -> Moment:
    """Show a column around one of its rows, with its limits."""
    times, values = record.run.trace["time_s"], record.run.trace[column]
    place = min(place, len(times) - 1)
    shown = times[max(place - SHOWN_PERIODS, 0) : place + SHOWN_PERIODS + 1]
    return Moment(
        start_s=float(shown[0]),
        end_s=float(shown[-1]),
        column=column,
        levels=tuple(Mark(words=f"limit {limit:.4g}{unit}", value=limit) for limit in limits),
        point=Point(
            words=f"{values[place]:.4g}{unit} applied", time_s=float(times[place]), value=float(values[place])
        ),
    )


def _in_words(angle: float, digits: int) -> str:
    """Write an angle in degrees, or in radians where degrees are too large for a number."""
    degrees = math.degrees(angle)
    return f"{degrees:.{digits}g}°" if math.isfinite(degrees) else f"{angle:.{digits}g} rad"


def reference_range(record: CurrentRecord) -> Margin:
    limit = record.scenario.drive.rating.current_limit_a
    lowest = record.run.observed.reference_lowest
    highest = record.run.observed.reference_highest
    value = normalised(min(lowest, limit - highest), limit)
    return Margin("CMD-1", value, f"{lowest:.4g} A to {highest:.4g} A")


ADV_1 = Check(
    id="ADV-1",
    families=("standstill", "base speed"),
    requirement="The advance angle is 0 whenever the speed in that step's own Sense is below base speed.",
    source="P5",
    limit="exactly 0° below {base}",
    scenarios="runs that come below base speed",
    formula="1 when every such angle is exactly 0, else minus the largest of them in degrees",
    why="Below base speed the supply exceeds the EMF, and an advanced current only costs torque.",
    evaluate=angle_below_base,
    moment=below_base_moment,
    reason_not_applicable=unless_speeds(below_base),
)
ADV_2 = Check(
    id="ADV-2",
    every_run=True,
    requirement="The advance angle stays within 0° to 90°.",
    source="P10",
    limit="0° to 90°",
    scenarios="every run",
    formula="distance from the nearer end / 90°, before the plant clamps the angle",
    why="At 90° the greatest speed is reached; beyond it the torque falls again.",
    evaluate=angle_range,
    moment=angle_moment,
)
CMD_1 = Check(
    id="CMD-1",
    every_run=True,
    requirement="The current reference stays within 0 to the limit.",
    source="P3",
    limit="0 to {current}",
    scenarios="every run",
    formula="distance from the nearer end / {current}, before the plant clamps the reference",
    why="The phase current is limited by its reference alone, and there is no braking with a negative one.",
    evaluate=reference_range,
    moment=reference_moment,
)
