"""Check of the range of what a controller answers with."""

from __future__ import annotations

import numpy as np

from drivegate.checks.check import Check
from drivegate.checks.margin import GREATEST, Margin, normalised
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.run import DUTY_RATIOS

PERIOD_SHARE = 0.2
"""Greatest change of the control period (1)."""


def command_range(record: DutyRecord) -> Margin:
    """Judge duty ratios and the next control period; a leg that is none of the contract's ends the run."""
    ratios = np.stack([record.run.commands[name] for name in DUTY_RATIOS])
    lowest, highest = float(ratios.min()), float(ratios.max())
    margin = Margin("DUT-1", _inside(lowest, highest), f"duty ratios {lowest:.4g} to {highest:.4g}")
    periods = record.run.commands["next_period"]
    chosen = periods[periods != 0.0]
    if chosen.size == 0:
        return margin
    own = record.scenario.control_period_s
    with np.errstate(over="ignore"):
        farthest = float(np.max(np.abs(chosen / own - 1.0)))
    # Also where it is no number.
    away = farthest if farthest < GREATEST else GREATEST
    finding = f"control period changed by {100.0 * away:.3g} %"
    return min(
        margin,
        Margin("DUT-1", normalised(PERIOD_SHARE - away, PERIOD_SHARE), finding),
        key=lambda one: one.value,
    )


def _inside(lowest: float, highest: float) -> float:
    """Judge a range: at its ends is every controller that clamps, so that the distance from them shows nothing."""
    outside = min(lowest, 1.0 - highest)
    return 1.0 if outside >= 0.0 else normalised(outside, 1.0)


DUT_1 = Check(
    id="DUT-1",
    every_run=True,
    requirement="Duty ratios stay within 0 to 1, and a control period that is asked for within 20 % of the drive's.",
    limit="0 to 1, and ± 20 %",
    scenarios="every run",
    formula="1 within 0 to 1, else minus what is outside, before it is clamped; 1 - change of the period / 20 %",
    why="A counter that is given more than its period wraps or saturates, and then the voltage is another one.",
    evaluate=command_range,
)
