"""What a step of the link's voltage does to the torque: a controller that measures the link at once answers it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from drivegate.checks.margin import Margin, Mark, Moment, Point, at_most
from drivegate.checks.means import exact_mean
from drivegate.contracts.duty.checks.current import FREE_SHARE
from drivegate.contracts.duty.checks.judged import (
    SHOWN_BEFORE,
    decisive,
    is_within_reach,
    least_free,
    undistorted,
)
from drivegate.contracts.duty.current_bandwidth import declared_rise_s
from drivegate.contracts.duty.record import DutyRecord, DutyWindow
from drivegate_models.pm_ac.plant.dc_link import is_ideal

REMAINING_SHARE = 0.5
"""Greatest share that may be left of what a step moves the torque by before an answer acts (1)."""


@dataclass(frozen=True)
class LinkStep:
    """A step of the link under a constant torque reference, and what the torque does after it."""

    window: DutyWindow
    """The steady state that follows it."""
    before_v: float
    """Voltage of the link before it (V)."""
    unit: str
    """Unit of the torque."""
    torque: NDArray[np.float64]
    """Torque after it (N·m), or q current in its place (A)."""
    steady: float
    """What that comes to (N·m, or A)."""
    error: float
    """Greatest distance from the range of the steady state, once it is judged (N·m, or A)."""
    allowed: float
    """Greatest distance that is allowed (N·m, or A)."""
    judged_s: float
    """Time after the step from which on it is judged (s)."""
    place: int
    """Control period of that distance, after the step."""

    @property
    def margin(self) -> Margin:
        window = self.window
        return Margin(
            "STP-1",
            at_most(self.error, self.allowed),
            f"{self.error:.4g} {self.unit} off {1e3 * self.judged_s:.4g} ms after the link steps from "
            f"{self.before_v:.5g} to {window.link:.5g} V, {self.allowed:.4g} {self.unit} are allowed, at "
            f"{window.dwell.speed_rpm:.5g} rpm",
        )


def link_response(record: DutyRecord) -> Margin | None:
    found = decisive_link_step(record)
    return None if found is None else found.margin


def decisive_link_step(record: DutyRecord) -> LinkStep | None:
    """Find the step of the link with the least margin; None where none is judged."""
    found = decisive((step, step.margin) for step in _steps(record))
    return None if found is None else found[0]


def link_step_moment(record: DutyRecord, step: LinkStep) -> Moment:
    """Show the torque after a step of the link, and what is allowed."""
    period, begin = record.scenario.control_period_s, step.window.dwell.start
    sign = 1.0 if step.torque[step.place] >= step.steady else -1.0
    return Moment(
        start_s=max(begin - SHOWN_BEFORE * period, 0.0),
        end_s=min(begin + 3.0 * step.judged_s, step.window.end_s),
        column="quadrature_current_a" if record.follows_current else "torque_nm",
        origin_s=begin,
        levels=(
            Mark(words="steady", value=step.steady),
            Mark(words=f"{step.allowed:.3g} allowed", value=step.steady + sign * step.allowed),
        ),
        instants=(Mark(words=f"{1e3 * step.judged_s:.3g} ms", value=begin + step.judged_s),),
        point=Point(
            words=f"{step.error:.3g} off",
            time_s=begin + (step.place + 0.5) * period,
            value=float(step.torque[step.place]),
        ),
    )


def _steps(record: DutyRecord) -> Iterator[LinkStep]:
    is_plain = record.is_nominal and not record.scenario.restarts_s
    if not is_plain or not record.document.has_sensor or not is_ideal(record.plant.dc_link):
        return
    for first, second in pairwise(record.steady):
        one, other = first.dwell, second.dwell
        if (
            one.torque_reference_nm is not None
            and (one.torque_reference_nm, one.speed_rpm) == (other.torque_reference_nm, other.speed_rpm)
            and one.end == other.start
            and one.supply_v != other.supply_v
            and _is_free(record, second, min(first.link, second.link))
        ):
            yield _response(record, first, second)


def _is_free(record: DutyRecord, window: DutyWindow, link: float) -> bool:
    """Return True if the lower voltage of the link leaves room, so that no weakening changes with it."""
    torque = window.dwell.torque_reference_nm
    assert torque is not None, "the reference is a torque"
    if not is_within_reach(record, window.speed_reference, link, torque):
        return False
    used = least_free(record.plant, window.speed_reference, torque).voltage
    return used <= FREE_SHARE * undistorted(record.plant, link)


def _response(record: DutyRecord, first: DutyWindow, second: DutyWindow) -> LinkStep:
    period, bandwidth = record.scenario.control_period_s, record.declaration.current_bandwidth
    column = record.run.column("quadrature" if record.follows_current else "torque")
    torque = column[record.periods(second.dwell.start, second.dwell.end)]
    steady = column[record.periods(second.start_s, second.end_s)]
    outside = np.maximum(torque - np.max(steady), np.min(steady) - torque)
    # Until an answer to the step acts, every controller's torque moves by the same.
    moved = max(float(np.max(outside[: record.document.inverter.update_delay + 1])), 0.0)
    rise = record.limits.rise_time_s if bandwidth is None else declared_rise_s(record.document, bandwidth)
    judged = min(round(rise / period), len(outside) - 1)
    place = judged + int(np.argmax(outside[judged:]))
    allowed = record.limits.torque_error_nm
    if record.follows_current:
        rated = record.document.rating.rated_torque_nm
        allowed *= record.quadrature_reference(rated) / rated
    return LinkStep(
        second,
        first.link,
        "A of q current" if record.follows_current else "N·m",
        torque,
        exact_mean(steady),
        max(float(outside[place]), 0.0),
        allowed + REMAINING_SHARE * moved,
        judged * period,
        place,
    )
