"""Check of the current along the magnet's axis behind steps of the torque reference."""

from __future__ import annotations

import numpy as np

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, at_most
from drivegate.checks.record import Record
from drivegate.contracts.duty.checks.judged import duty_record, worst
from drivegate.contracts.duty.checks.steps import (
    TorqueStep,
    is_free,
    least_state,
    torque_steps,
    voltage_time_s,
)
from drivegate.contracts.duty.record import DutyRecord, exact_mean

TRANSIENT_PERIODS = 100
"""Control periods behind a step that are judged; what changes later is a choice, not coupling."""
LINEAR_SHARE = 0.5
"""Time that the voltage takes to move the currents, over the stated rise time, up to which a step is judged (1)."""
_LEVEL_PERIODS = 25


def decoupled_current(record: Record) -> Margin | None:
    """Judge how far a step of the torque moves the d current beyond where it was and where it goes."""
    judged = duty_record(record)
    if not judged.is_nominal:
        return None
    return worst(_moved(judged, step) for step in torque_steps(judged) if _is_judged(judged, step))


def _is_judged(record: DutyRecord, step: TorqueStep) -> bool:
    return is_free(record, step) and voltage_time_s(record, step) <= LINEAR_SHARE * record.limits.rise_time_s


def _moved(record: DutyRecord, step: TorqueStep) -> Margin:
    begin = step.rows.start
    end = min(begin + TRANSIENT_PERIODS, step.rows.stop)
    direct = record.run.column("direct")
    levels = [exact_mean(direct[place - _LEVEL_PERIODS : place]) for place in (begin, end)]
    rows = direct[begin:end]
    moved = max(min(levels) - float(np.min(rows)), float(np.max(rows)) - max(levels), 0.0)
    first, last = (least_state(record, step, torque).quadrature for torque in (step.before, step.after))
    size = abs(last - first)
    allowed = record.limits.coupled_current * size
    told = (
        f"d current moved by {moved:.4g} A by a q step of {size:.4g} A, from {step.before:.4g} to {step.after:.4g} N·m "
        f"at {step.speed_rpm:.5g} rpm"
    )
    return Margin("DEC-1", at_most(moved, allowed), told)


DEC_1 = Check(
    id="DEC-1",
    families=("torque step",),
    requirement="A step of the torque moves the d current hardly beyond where it was and where it goes.",
    source="the contract",
    subject="candidate",
    level="required",
    limit="{coupling} of the step of the q current",
    scenarios="steps of 10 % of rated torque and more on the nominal drive, so small that no voltage is limited",
    formula="1 - d current outside of its values before and 100 control periods after / {coupling} of the q step",
    why="Rotation couples both axes, and what is not decoupled is current and loss for nothing.",
    evaluate=decoupled_current,
)
