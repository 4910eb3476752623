"""Check of the torque's sign in the steady state."""

from __future__ import annotations

import math

import numpy as np

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, Moment, worst_required
from drivegate.contracts.current.checks.convergence import ABOVE_BASE_SPEED, LOADED, described
from drivegate.contracts.current.checks.shown import around, decisive, ripple_rows
from drivegate.contracts.current.record import CurrentRecord, SteadyWindow, rated_torque

HALF_LOAD = 0.5
"""Least share of the torque of rated power at which the sign is judged (1)."""
_ROUNDING = 1e-6


def torque_sign(record: CurrentRecord) -> Margin | None:
    return worst_required([_margin(window) for window in record.nominal_windows() if _is_judged(window)])


def _is_judged(window: SteadyWindow) -> bool:
    least = HALF_LOAD * rated_torque(window.scenario, window.speed) * (1.0 - _ROUNDING)
    return window.torque_required >= least and math.isfinite(window.values.torque_lowest)


def sign_moment(record: CurrentRecord) -> Moment | None:
    """Show the least torque around the place where it is least."""
    judged = [(window, _margin(window)) for window in record.nominal_windows() if _is_judged(window)]
    window = decisive(judged)
    rows = None if window is None else ripple_rows(record, window)
    if window is None or rows is None or rows.stop == rows.start:
        return None
    trace = record.run.trace[rows]
    lowest, mean = trace["torque_lowest_nm"], window.values.torque
    place = int(np.argmin(lowest))
    levels = ("limit 0 N·m", 0.0), (f"mean {mean:.3g} N·m", mean)
    words, quantity = f"{lowest[place]:.3g} N·m", "least torque (N·m)"
    return around(trace["time_s"], place, [("least torque", lowest)], quantity, levels, words)


def _margin(window: SteadyWindow) -> Margin:
    lowest, mean = window.values.torque_lowest, window.values.torque
    # A mean of no torque at all has no share to measure by.
    value = lowest / mean if mean > 0.0 else -1.0
    return Margin("TRQ-1", value, f"at least {lowest:.3g} N·m, {mean:.3g} N·m on average{described(window)}")


TRQ_1 = Check(
    id="TRQ-1",
    families=LOADED,
    requirement="The torque is never negative in the steady state under half of {power} and more.",
    source="P9",
    level="advisory",
    limit="above 0 N·m",
    scenarios=(
        "every steady stretch of {stretch} or more above base speed that requires half the torque of {power} or more, "
        "on the nominal drive, in its last second"
    ),
    formula="least torque / mean torque",
    why="The paper holds a torque that changes its sign against conventional drives with phase advance.",
    evaluate=torque_sign,
    moment=sign_moment,
    reason_not_applicable=ABOVE_BASE_SPEED,
)
