"""Check of starts from standstill."""

from __future__ import annotations

from math import degrees

import numpy as np
from numpy.typing import NDArray

from drivegate.checks.check import Check
from drivegate.checks.course import course_of
from drivegate.checks.margin import Margin, Mark, Moment, Point, at_most, normalised
from drivegate.contracts.duty.checks.judged import unless_sensed
from drivegate.contracts.duty.record import DutyRecord
from drivegate.scenarios.rotation import sense_of
from drivegate_models.units import RADIANS_PER_RPM

REACHED = 0.95
"""Share of the speed reference that has to be reached (1)."""
BACKWARD_DEG = 60.0
"""Greatest turn against the reference (electrical degrees)."""


def start(record: DutyRecord) -> Margin | None:
    """Judge a start under the load: the speed at its end, and how far the shaft has turned back."""
    scenario = record.scenario
    wanted = _wanted(record)
    if wanted is None:
        return None
    reached = record.steady[-1].speed / wanted
    backward = degrees(max(-float(np.min(_turned(record, wanted))), 0.0))
    place = f"from {scenario.initial_angle_deg:g}°"
    return min(
        Margin(
            "STA-1", normalised(reached - REACHED, REACHED), f"{100.0 * reached:.4g} % of the speed {place}"
        ),
        Margin("STA-1", at_most(backward, BACKWARD_DEG), f"{backward:.3g}° backward {place}"),
        key=lambda margin: margin.value,
    )


def _wanted(record: DutyRecord) -> float | None:
    """Return the speed reference of a start (rad/s); None where nothing is judged."""
    scenario, steady = record.scenario, record.steady
    wanted = scenario.speed_rpm[-1][1] * RADIANS_PER_RPM
    if scenario.initial_speed_rpm != 0.0 or not record.is_nominal or wanted == 0.0 or not steady:
        return None
    if steady[-1].dwell != record.windows[-1][0]:
        # A trip that is right ended the run before.
        return None
    return wanted if steady[-1].torque_reference is None else None


def _turned(record: DutyRecord, wanted: float) -> NDArray[np.float64]:
    """Return the turn of the shaft towards its reference since the start, shape (n,) (electrical rad)."""
    turning = sense_of(wanted) * record.scenario.control_period_s * record.document.machine.pole_pairs
    return np.cumsum(record.run.column("speed")) * turning


def start_moment(record: DutyRecord) -> Moment | None:
    """Show how far the shaft turns back from standstill, or the speed until it should have reached its reference."""
    wanted = _wanted(record)
    if wanted is None:
        return None
    period, turned = record.scenario.control_period_s, _turned(record, wanted)
    speed = record.run.column("speed") / RADIANS_PER_RPM
    last = record.steady[-1]
    backward = degrees(max(-float(np.min(turned)), 0.0))
    if at_most(backward, BACKWARD_DEG) < normalised(last.speed / wanted - REACHED, REACHED):
        place = int(np.argmin(turned))
        shown = np.degrees(turned[: 2 * (place + 1)])
        return Moment(
            start_s=0.0,
            end_s=len(shown) * period,
            quantity="turn towards the reference (el. deg)",
            courses=(course_of("turn", (np.arange(len(shown)) + 1.0) * period, shown),),
            levels=(Mark(words=f"limit {-BACKWARD_DEG:g}°", value=-BACKWARD_DEG),),
            point=Point(words=f"{backward:.3g}° backward", time_s=(place + 1.0) * period, value=-backward),
        )
    place = len(speed) - 1
    end, words = last.end_s, f"{100.0 * last.speed / wanted:.4g} % of the speed"
    least, reference = REACHED * wanted / RADIANS_PER_RPM, wanted / RADIANS_PER_RPM
    return Moment(
        start_s=0.0,
        end_s=end,
        column="speed_rpm",
        levels=(
            Mark(words="reference", value=reference),
            Mark(words=f"limit {least:.4g} rpm", value=least),
        ),
        point=Point(words=words, time_s=min((place + 0.5) * period, end), value=float(speed[place])),
    )


STA_1 = Check(
    id="STA-1",
    families=("start",),
    requirement=(
        "From any angle of the rotor the shaft starts under its load, reaches 95 % of its speed reference, "
        "and turns back by at most 60° electrical."
    ),
    limit="95 % of the speed, 60° electrical backward",
    scenarios="starts of the nominal drive from standstill, from 24 rotor angles and drawn ones",
    formula="the lesser of speed / 95 % of the reference - 1 and 1 - backward turn / 60°",
    why="A drive that starts from some angles only fails in the field.",
    evaluate=start,
    reason_not_applicable=unless_sensed,
    moment=start_moment,
)
