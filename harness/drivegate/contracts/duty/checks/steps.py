"""Steps of the torque reference, and the check of what follows them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import copysign, hypot, isfinite, isnan, sqrt

import numpy as np
from numpy.typing import NDArray

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, Mark, Moment, Point, at_most
from drivegate.contracts.duty.checks.judged import (
    SHOWN_BEFORE,
    is_within_reach,
    least_free,
    undistorted,
    worst,
)
from drivegate.contracts.duty.checks.link_steps import decisive_link_step, link_response, link_step_moment
from drivegate.contracts.duty.current_bandwidth import REMAINING, declared_rise_s, limited_rise_s, lost_share
from drivegate.contracts.duty.current_reference import voltage_along_none
from drivegate.contracts.duty.record import DutyRecord
from drivegate_models.pm_ac.fundamental import SteadyState, steady_state
from drivegate_models.pm_ac.plant.dc_link import is_ideal
from drivegate_models.units import RADIANS_PER_RPM

SMALLEST_SHARE = 0.1
"""Least step that is judged, over rated torque (1)."""
VOLTAGE_SHARE = 0.8
"""Greatest share of the undistorted voltage that the torques at both ends may take (1)."""
_CELLS = 16
"""Parts into which the way of the currents is divided."""
REACHED = 0.9
"""Share of a step by which its time is measured, without dead time and drops (1)."""


@dataclass(frozen=True)
class TorqueStep:
    """A step of the torque reference at a held speed, and the control periods up to the next change."""

    time_s: float
    """When it happens (s)."""
    speed_rpm: float
    """Speed that the shaft is held at (rpm)."""
    before: float
    after: float
    """The reference (N m)."""
    rows: slice
    """The control periods."""
    steady: tuple[slice, slice]
    """The control periods before it and after it in which the steady states are judged."""


def torque_steps(record: DutyRecord) -> Iterator[TorqueStep]:
    """Find the steps at which nothing but the torque reference changes."""
    for windows in pairwise(record.steady):
        first, second = (window.dwell for window in windows)
        before, after = first.torque_reference_nm, second.torque_reference_nm
        if before is None or after is None or first.end != second.start:
            continue
        rows = record.periods(second.start, second.end)
        one, other = (record.periods(window.start_s, window.end_s) for window in windows)
        yield TorqueStep(second.start, second.speed_rpm, before, after, rows, (one, other))


@dataclass(frozen=True)
class StepResponse:
    """What follows a step of the torque reference."""

    step: TorqueStep
    overshoot: float
    """Greatest torque beyond the reference, over the step (1)."""
    rise_s: float
    """Time to 90 % of the step (s); infinite where that is not reached."""
    allowed_s: float
    """Longest time that is allowed (s)."""
    allowed_overshoot: float
    """Greatest overshoot that is allowed (1)."""
    reached: float
    """Share of the step that is to be reached by then (1)."""
    reached_s: float
    """Time to that share (s); infinite where that is not reached."""
    margin: Margin


def step_response(record: DutyRecord) -> Margin | None:
    """Judge overshoot and rise time of the torque where the voltage leaves room for both."""
    decisive = decisive_step(record)
    return None if decisive is None else decisive.margin


def decisive_step(record: DutyRecord) -> StepResponse | None:
    """Find the step with the least margin; None where none is judged."""
    return min(step_responses(record), key=lambda response: response.margin.value, default=None)


def step_responses(record: DutyRecord) -> Iterator[StepResponse]:
    if record.is_nominal:
        yield from (_response(record, step) for step in torque_steps(record) if is_free(record, step))


def torque_transients(record: DutyRecord) -> Margin | None:
    """Judge what follows steps of the torque reference, and of the link under one."""
    return worst((step_response(record), link_response(record)))


def step_moment(record: DutyRecord) -> Moment | None:
    """Show the torque after the decisive step, with its reference and what is allowed."""
    response, link = decisive_step(record), decisive_link_step(record)
    if link is not None and (response is None or link.margin.value < response.margin.value):
        return link_step_moment(record, link)
    return None if response is None else _moment(record, response)


def _moment(record: DutyRecord, response: StepResponse) -> Moment:
    step, period = response.step, record.scenario.control_period_s
    followed, before, after = _followed(record, step)
    size = after - before
    is_late = at_most(response.reached_s, response.allowed_s) < at_most(
        response.overshoot, response.allowed_overshoot
    )
    reached = Mark(words=f"{100.0 * response.reached:.3g} %", value=before + response.reached * size)
    words = f"{100.0 * response.allowed_overshoot:.3g} % allowed"
    highest = Mark(words=words, value=after + response.allowed_overshoot * size)
    if is_late and isfinite(response.reached_s):
        time, value, words = (
            step.time_s + response.reached_s,
            reached.value,
            f"{1e3 * response.reached_s:.3g} ms",
        )
    else:
        place = int(np.argmax(followed / size))
        time, value = step.time_s + (place + 0.5) * period, float(followed[place])
        beyond = 100.0 * (value - after) / size
        words = f"{100.0 + beyond:.3g} % reached" if is_late else f"{beyond:.3g} %"
    longest = max(3.0 * response.allowed_s, 1.5 * (time - step.time_s))
    return Moment(
        start_s=max(step.time_s - SHOWN_BEFORE * period, 0.0),
        end_s=min(step.time_s + longest, step.rows.stop * period),
        column="quadrature_current_a" if record.follows_current else "torque_nm",
        origin_s=step.time_s,
        levels=(Mark(words="reference", value=after), reached if is_late else highest),
        instants=(
            Mark(words=f"{1e3 * response.allowed_s:.3g} ms allowed", value=step.time_s + response.allowed_s),
        ),
        point=Point(words=words, time_s=time, value=value),
    )


def is_free(record: DutyRecord, step: TorqueStep) -> bool:
    """Return True if a step is great enough to be judged, and leaves voltage for its own response."""
    smallest = SMALLEST_SHARE * record.document.rating.rated_torque_nm
    speed, link = step.speed_rpm * RADIANS_PER_RPM, record.document.inverter.link_voltage_v
    torques = (step.before, step.after)
    if record.scenario.supply_v is not None:
        return False
    if not all(is_within_reach(record, speed, link, torque) for torque in torques):
        return False
    if not is_ideal(record.plant.dc_link) and any(
        isnan(least_state(record, step, torque).torque) for torque in torques
    ):
        # The link takes the power of one of them only with currents of its own.
        return False
    used = _used_voltage(record, step)
    return abs(step.after - step.before) >= smallest and used <= VOLTAGE_SHARE * undistorted(
        record.plant, link
    )


def overshoot_of(torque: NDArray[np.float64], end: float, step: float) -> float:
    """Return how far torques go beyond the end (N·m) of a step, over the signed step (N·m)."""
    return max(float(np.max((torque - end) / step)), 0.0)


def least_state(record: DutyRecord, step: TorqueStep, torque: float) -> SteadyState:
    """Find the steady state of least current for a torque at the speed of a step, whatever voltage it takes."""
    return least_free(record.plant, step.speed_rpm * RADIANS_PER_RPM, torque)


def _response(record: DutyRecord, step: TorqueStep) -> StepResponse:
    followed, before, after = _followed(record, step)
    size = after - before
    overshoot = overshoot_of(followed, after, size)
    lost = lost_share(record.document, record.declaration.current_bandwidth, _moved_flux(record, step))
    share, highest = max(REACHED - lost, 0.0), record.limits.overshoot + lost
    done, period = (followed - before) / size, record.scenario.control_period_s
    time = _time_to(share, done, period)
    allowed = allowed_rise_s(record, step)
    unit = "A of q current" if record.follows_current else "N·m"
    place = f"from {before:.4g} to {after:.4g} {unit} at {step.speed_rpm:.5g} rpm"
    bandwidth = record.declaration.current_bandwidth
    declared = "" if bandwidth is None else f" by the declared {bandwidth:g} rad/s"
    percent = f"{100.0 * share:.3g} %"
    rise = f"{1e3 * time:.4g} ms to {percent}" if isfinite(time) else f"{percent} is not reached"
    beyond = f", {100.0 * highest:.3g} % are allowed," if lost > 0.0 else ""
    margin = min(
        Margin(
            "STP-1",
            at_most(overshoot, highest),
            f"overshoot {100.0 * overshoot:.3g} %{beyond} {place}",
        ),
        Margin(
            "STP-1", at_most(time, allowed), f"{rise}, {1e3 * allowed:.4g} ms are allowed{declared}, {place}"
        ),
        key=lambda margin: margin.value,
    )
    return StepResponse(
        step, overshoot, _time_to(REACHED, done, period), allowed, highest, share, time, margin
    )


def _time_to(share: float, done: NDArray[np.float64], period: float) -> float:
    """Return the time (s) to a share of a step that is done (1); infinite where that is not reached."""
    reached = np.flatnonzero(done >= share)
    return float(reached[0] + 1) * period if reached.size else float("inf")


def _followed(record: DutyRecord, step: TorqueStep) -> tuple[NDArray[np.float64], float, float]:
    """Return the torque after a step (N·m), or the q current in its place (A), with its reference before and after."""
    if not record.follows_current:
        return record.run.column("torque")[step.rows], step.before, step.after
    before, after = (record.quadrature_reference(torque) for torque in (step.before, step.after))
    return record.run.column("quadrature")[step.rows], before, after


def allowed_rise_s(record: DutyRecord, step: TorqueStep) -> float:
    """Return the longest time of a step: the stated one and what the voltage limit adds, or that of a bandwidth."""
    bandwidth, voltage_time = record.declaration.current_bandwidth, voltage_time_s(record, step)
    remaining = REMAINING if record.follows_current else _remaining_currents(record, step)
    if bandwidth is None:
        return limited_rise_s(record.document, remaining, voltage_time, straight_time_s(record, step))
    return declared_rise_s(record.document, bandwidth, remaining, voltage_time)


def _moved_flux(record: DutyRecord, step: TorqueStep) -> float:
    """Return the change of the flux linkage from one end of a step to the other (V s)."""
    drive = record.plant
    first, last = (least_state(record, step, torque) for torque in (step.before, step.after))
    return hypot(
        drive.direct_inductance * (last.direct - first.direct),
        drive.quadrature_inductance * (last.quadrature - first.quadrature),
    )


def _remaining_currents(record: DutyRecord, step: TorqueStep) -> float:
    """Return the share of the currents' step that remains where the torque has done 90 % of its own.

    With reluctance the torque is a square of the currents, and follows later than they do.
    """
    first, last = (least_state(record, step, torque) for torque in (step.before, step.after))
    halfway = steady_state(
        record.plant,
        0.0,
        0.5 * (first.direct + last.direct),
        0.5 * (first.quadrature + last.quadrature),
    ).torque
    # The torque at a share of the step that remains: last.torque + linear * share + square * share ** 2.
    square = 2.0 * (first.torque + last.torque - 2.0 * halfway)
    linear = first.torque - last.torque - square
    missing = (1.0 - REACHED) * (first.torque - last.torque)
    return 2.0 * missing / (linear + copysign(sqrt(linear * linear + 4.0 * square * missing), linear))


def voltage_time_s(record: DutyRecord, step: TorqueStep) -> float:
    """Return the time in which the voltage that both ends leave moves the currents from one to the other."""
    drive, flux = record.plant, _moved_flux(record, step)
    return flux / (undistorted(drive, drive.link_voltage) - _used_voltage(record, step))


def straight_time_s(record: DutyRecord, step: TorqueStep) -> float:
    """Return the time in which all of the voltage moves the currents straight from one end to the other (s).

    At each place the flux moves by what the voltage limit leaves of it in this direction, beside the voltage that holds
    the currents there.
    """
    drive, electrical = record.plant, record.plant.pole_pairs * step.speed_rpm * RADIANS_PER_RPM
    first, last = (least_state(record, step, torque) for torque in (step.before, step.after))
    shares = (np.arange(_CELLS) + 0.5) / _CELLS
    direct = first.direct + shares * (last.direct - first.direct)
    quadrature = first.quadrature + shares * (last.quadrature - first.quadrature)
    along = drive.resistance * direct - electrical * drive.quadrature_inductance * quadrature
    across = drive.resistance * quadrature + electrical * (
        drive.direct_inductance * direct + drive.magnet_flux
    )
    ways = (
        drive.direct_inductance * (last.direct - first.direct),
        drive.quadrature_inductance * (last.quadrature - first.quadrature),
    )
    flux, limit = hypot(*ways), undistorted(drive, drive.link_voltage)
    ahead = (along * ways[0] + across * ways[1]) / flux
    rates = np.sqrt(ahead * ahead + limit * limit - along * along - across * across) - ahead
    return flux * float(np.mean(1.0 / rates))


def _used_voltage(record: DutyRecord, step: TorqueStep) -> float:
    """Return the greatest voltage of both ends (V), for a q current also that without a d current."""
    torques = (step.before, step.after)
    used = [least_state(record, step, torque).voltage for torque in torques]
    if record.follows_current:
        used += [voltage_along_none(record.document, step.speed_rpm, torque) for torque in torques]
    return max(used)


STP_1 = Check(
    id="STP-1",
    families=("torque step", "torque supply step"),
    requirement=(
        "After a step of its reference the torque overshoots by at most {overshoot}, and reaches 90 % of the "
        "step within the longest time that is allowed. After a step of the link it is steady by then, within "
        "{torque_error} and half of what the step itself moves it."
    ),
    limit="overshoot {overshoot}, {rise}; after a step of the link torque {torque_error}",
    scenarios="steps of 10 % of rated torque and more on the nominal drive, that take 80 % of the voltage at most; "
    "steps of the link under a torque that takes 90 % of the lower voltage at most",
    formula="the least of 1 - overshoot / {overshoot}, 1 - time to 90 % / the longest one and, after a step of the "
    "link, 1 - |torque - steady torque| / limit",
    why="Loops above the torque are laid out for its response, and links sag.",
    evaluate=torque_transients,
    moment=step_moment,
)
