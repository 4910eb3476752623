"""Check of starts from standstill."""

from __future__ import annotations

from math import degrees

import numpy as np

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, at_most, normalised
from drivegate.checks.record import Record
from drivegate.contracts.duty.checks.judged import duty_record
from drivegate_models.units import RADIANS_PER_RPM

REACHED = 0.95
"""Share of the speed reference that has to be reached (1)."""
BACKWARD_DEG = 60.0
"""Greatest turn against the reference (electrical degrees)."""


def start(record: Record) -> Margin | None:
    """Judge a start under the load: the speed at its end, and how far the shaft has turned back."""
    judged = duty_record(record)
    scenario = judged.scenario
    wanted = scenario.speed_rpm[-1][1] * RADIANS_PER_RPM
    steady = judged.steady
    if scenario.initial_speed_rpm != 0.0 or not judged.is_nominal or wanted == 0.0 or not steady:
        return None
    if steady[-1].torque_reference is not None:
        return None
    reached = steady[-1].speed / wanted
    turned = (
        np.cumsum(judged.run.column("speed")) * scenario.control_period_s * judged.document.machine.pole_pairs
    )
    backward = degrees(max(-float(np.min(turned)), 0.0))
    place = f"from {scenario.initial_angle_deg:g}°"
    return min(
        Margin(
            "STA-1", normalised(reached - REACHED, REACHED), f"{100.0 * reached:.4g} % of the speed {place}"
        ),
        Margin("STA-1", at_most(backward, BACKWARD_DEG), f"{backward:.3g}° backward {place}"),
        key=lambda margin: margin.value,
    )


STA_1 = Check(
    id="STA-1",
    families=("start",),
    requirement="From any angle of the rotor the shaft starts under its load, and does not turn back far.",
    source="the contract",
    subject="candidate",
    level="required",
    limit="95 % of the speed, 60° electrical backward",
    scenarios="starts of the nominal drive from standstill, from 24 angles of the rotor",
    formula="the lesser of speed / 95 % of the reference - 1 and 1 - backward turn / 60°",
    why="A drive that starts from some angles only fails in the field.",
    evaluate=start,
)
