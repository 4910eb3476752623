"""Check of the torque that a controller reports."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

import numpy as np

from drivegate.checks.check import Check
from drivegate.checks.course import course_of
from drivegate.checks.margin import Margin, Mark, Moment, at_most
from drivegate.checks.means import exact_mean
from drivegate.contracts.duty.checks.judged import STEADY_FAMILIES, at, decisive, worst
from drivegate.contracts.duty.record import DutyRecord, DutyWindow

_ESTIMATE: Final = "torque"
"""Field of a command that has the estimate."""


def estimated_torque(record: DutyRecord) -> Margin | None:
    return worst(margin for _, margin in _errors(record))


def estimate_moment(record: DutyRecord) -> Moment | None:
    """Show estimate and torque in the stretch that decides."""
    least = decisive(_errors(record))
    if least is None:
        return None
    window, _ = least
    rows, period = record.periods(window.start_s, window.end_s), record.scenario.control_period_s
    times = (np.arange(rows.start, rows.stop) + 0.5) * period
    estimate = record.run.commands[_ESTIMATE][rows]
    return Moment(
        start_s=window.start_s,
        end_s=window.end_s,
        quantity="torque (N·m)",
        courses=(
            course_of("estimate", times, estimate),
            course_of("torque", times, record.run.column("torque")[rows]),
        ),
        levels=(
            Mark(words="mean estimate", value=exact_mean(estimate)),
            Mark(words="mean torque", value=window.torque),
        ),
    )


def _errors(record: DutyRecord) -> Iterator[tuple[DutyWindow, Margin]]:
    for window in record.nominal:
        mean = exact_mean(record.run.commands[_ESTIMATE][record.periods(window.start_s, window.end_s)])
        if not math.isnan(mean):
            words = f"estimate {mean:.4g} N·m of a torque of {window.torque:.4g} N·m {at(window)}"
            error = abs(mean - window.torque)
            yield window, Margin("EST-1", at_most(error, record.limits.estimate_error_nm), words)


EST_1 = Check(
    id="EST-1",
    families=STEADY_FAMILIES,
    requirement=(
        "In steady state the controller's mean estimate of the torque is within {estimate_error} of the mean "
        "torque."
    ),
    level="advisory",
    limit="torque {estimate_error}",
    scenarios="steady stretches of the nominal drive in which every command has an estimate of the torque",
    formula="1 - |mean estimate - mean torque| / {estimate_error}",
    why="A supervisor limits torque and detects an unintended one by what the controller reports.",
    evaluate=estimated_torque,
    moment=estimate_moment,
)
