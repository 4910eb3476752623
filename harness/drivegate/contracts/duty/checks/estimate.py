"""Check of the torque that a controller reports."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, at_most
from drivegate.checks.means import exact_mean
from drivegate.contracts.duty.checks.judged import STEADY_FAMILIES, at, worst
from drivegate.contracts.duty.record import DutyRecord

_ESTIMATE: Final = "torque"
"""Field of a command that has the estimate."""


def estimated_torque(record: DutyRecord) -> Margin | None:
    return worst(_errors(record))


def _errors(record: DutyRecord) -> Iterator[Margin]:
    for window in record.nominal:
        mean = exact_mean(record.run.commands[_ESTIMATE][record.periods(window.start_s, window.end_s)])
        if not math.isnan(mean):
            words = f"estimate {mean:.4g} N·m of a torque of {window.torque:.4g} N·m {at(window)}"
            yield Margin("EST-1", at_most(abs(mean - window.torque), record.limits.estimate_error_nm), words)


EST_1 = Check(
    id="EST-1",
    families=STEADY_FAMILIES,
    requirement="In steady state the controller's estimate of the torque is the mean torque.",
    level="advisory",
    limit="torque {estimate_error}",
    scenarios="steady stretches of the nominal drive in which every command has an estimate of the torque",
    formula="1 - |mean estimate - mean torque| / {estimate_error}",
    why="A supervisor limits torque and detects an unintended one by what the controller reports.",
    evaluate=estimated_torque,
)
