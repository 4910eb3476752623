"""The first difference of two candidates that answer with duty ratios, as plain data."""

from __future__ import annotations

from math import degrees
from typing import Any, Final

import numpy as np

from drivegate.studies.diff.duty.comparison import DutyDifference, differ
from drivegate.studies.diff.duty.steps import FIELDS
from drivegate.studies.diff.field import number_field, whole_field
from drivegate.studies.diff.jobs import Rule
from drivegate_models.machine.rotor_frame import phase_currents
from drivegate_models.units import RPM

UNITS: Final = {
    "next_period": "s",
    "torque": "N·m",
    "angle": "rad",
    "speed": "rad/s",
    "input_power": "W",
}
"""Units of a command's fields; of the others, none."""


def duty_difference(found: DutyDifference, rule: Rule) -> dict[str, Any]:
    """Write where two candidates differ, with the steps around."""
    steps = [_step(found, step, rule) for step in range(found.begin, found.end)]
    here = found.step - found.begin
    sense = found.driven.sense(found.step)
    return {
        "step": found.step,
        "time_s": sense.time,
        "sense": sense._asdict(),
        "plant": _plant(found),
        "commands": steps[here]["commands"],
        "before": steps[:here],
        "after": steps[here + 1 :],
    }


def _plant(found: DutyDifference) -> dict[str, Any]:
    """Tell the plant at the start of the step: speed, angle and link, and currents at the end of the step before."""
    run, step = found.driven.run, found.step
    speed, angle, link = (float(run.column(name)[step]) for name in ("speed", "angle", "link"))
    direct, quadrature = (
        float(run.column(name)[step - 1]) if step else 0.0 for name in ("direct", "quadrature")
    )
    currents = phase_currents(np.array([direct]), np.array([quadrature]), np.array([angle]))[0]
    return {
        "speed": speed,
        "speed_rpm": speed * RPM,
        "electrical_angle_deg": degrees(angle),
        "phase_currents": currents.tolist(),
        "direct_current": direct,
        "quadrature_current": quadrature,
        "link_voltage": link,
    }


def _step(found: DutyDifference, step: int, rule: Rule) -> dict[str, Any]:
    one, other = found.driven.run.commands[step], found.answers[step]
    return {
        "step": step,
        "sense": found.driven.sense(step)._asdict(),
        "commands": [_field(name, one, other, rule) for name in FIELDS],
    }


def _field(name: str, one: Any, other: Any, rule: Rule) -> dict[str, Any]:
    found = name in rule.judged and differ(name, one, other, rule)
    if isinstance(one[name], np.integer):
        return whole_field(name, int(one[name]), int(other[name]), differs=found)
    return number_field(name, UNITS.get(name, ""), float(one[name]), float(other[name]), differs=found)
