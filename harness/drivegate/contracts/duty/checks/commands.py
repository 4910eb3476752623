"""Check of the range of what a controller answers with."""

from __future__ import annotations

import numpy as np

from drivegate.checks.check import Check
from drivegate.checks.course import course_of
from drivegate.checks.margin import GREATEST, Margin, Mark, Moment, Point, normalised
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.run import DUTY_RATIOS

PERIOD_SHARE = 0.2
"""Greatest change of the control period (1)."""
SHOWN_PERIODS = 100
"""Control periods before and after the deciding one that figures show."""


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


def command_moment(record: DutyRecord) -> Moment:
    """Show the duty ratio, or the control period, that leaves its range furthest or comes nearest to its end."""
    commands, own = record.run.commands, record.scenario.control_period_s
    ratios = np.stack([commands[name] for name in DUTY_RATIOS])
    outside = np.maximum(-ratios, ratios - 1.0)
    leg, place = (int(index) for index in np.unravel_index(int(np.argmax(outside)), outside.shape))
    words, quantity, values, limits = (
        f"duty ratio of leg {leg + 1}",
        "duty ratio (1)",
        ratios[leg],
        (0.0, 1.0),
    )
    chosen = np.where(commands["next_period"] == 0.0, own, commands["next_period"])
    with np.errstate(over="ignore"):
        away = np.minimum(np.nan_to_num(np.abs(chosen / own - 1.0), nan=GREATEST), GREATEST)
    if normalised(PERIOD_SHARE - float(np.max(away)), PERIOD_SHARE) < _inside(
        float(ratios.min()), float(ratios.max())
    ):
        place = int(np.argmax(away))
        words, quantity, values = "control period", "control period over the drive's (1)", chosen / own
        limits = 1.0 - PERIOD_SHARE, 1.0 + PERIOD_SHARE
    rows = slice(max(place - SHOWN_PERIODS, 0), place + SHOWN_PERIODS)
    shown = np.clip(np.nan_to_num(values[rows]), -GREATEST, GREATEST)
    return Moment(
        start_s=rows.start * own,
        end_s=(rows.start + len(shown)) * own,
        quantity=quantity,
        courses=(course_of(words, (rows.start + np.arange(len(shown))) * own, shown),),
        levels=tuple(Mark(words=f"limit {limit:g}", value=limit) for limit in limits),
        point=Point(
            words=f"{values[place]:.4g}", time_s=(place + 0.5) * own, value=float(shown[place - rows.start])
        ),
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
    moment=command_moment,
)
