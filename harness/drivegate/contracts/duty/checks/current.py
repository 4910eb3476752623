"""Checks of the phase currents: their peaks, the steady current, and least current for the torque."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import ceil, inf, isfinite

import numpy as np
from numpy.typing import NDArray

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, Mark, Moment, Point, at_most
from drivegate.contracts.duty.checks.judged import (
    LOST_SHARE,
    STEADY_FAMILIES,
    UNWEAKENED_FAMILIES,
    at,
    greatest_required,
    if_unsensed,
    least_free,
    least_within,
    undistorted,
    worst,
)
from drivegate.contracts.duty.current_bandwidth import declared_rise_s
from drivegate.contracts.duty.current_reference import unless_current
from drivegate.contracts.duty.record import DutyRecord, DutyWindow
from drivegate.contracts.duty.run import idle_bridge
from drivegate_cases.scenario.control_periods import first_period_from
from drivegate_models.pm_ac.fundamental import SteadyState, steady_state
from drivegate_models.pm_ac.rectifying import rectifies

FREE_SHARE = 0.9
"""Share of the undistorted voltage below which nothing has to be weakened (1)."""
TAKE_OVER_PERIODS = 100
"""Control periods in which a controller takes over a machine whose diodes conduct."""
SHOWN_PERIODS = 100
"""Control periods before and after the peak that figures show."""
STEADY_EXCESS = 0.01
"""Excess of the steady current over its limit that rounding and residual regulation error may cause (1)."""
LEAST_TORQUE_SHARE = 0.1
"""Torque over the rated one from which shares of a current mean something (1)."""
EFFICIENCY_POINTS = (
    (0.0, 0.25),
    (0.0, 0.5),
    (0.0, 1.0),
    (0.5, 0.25),
    (0.5, 0.5),
    (0.5, 1.0),
    (1.0, 0.5),
    (1.0, 1.0),
)
"""Speed over base speed and torque over rated torque of the points of IEC 61800-9-2, from which the stimuli derive."""
_SAME = 1e-3


def peak_current(record: DutyRecord) -> Margin:
    """Judge the greatest phase current from the first answer on."""
    place, peak, allowed = _decisive_peak(record)
    if place is None:
        return Margin("OVC-1", 1.0, "no current is the controller's doing")
    more = f" of {allowed:.4g} A allowed there" if allowed > record.limits.peak_a else ""
    margin = Margin("OVC-1", at_most(peak, allowed), f"{peak:.5g} A{more}")
    if not margin.met and (since := _since_bridge_on(record, place)) is not None:
        margin = replace(
            margin, measured=f"{margin.measured}, {1e3 * since:.3g} ms after the bridge turns on"
        )
    return margin


def _since_bridge_on(record: DutyRecord, place: int) -> float | None:
    """Return the time since the bridge has turned on, at the start or after a restart (s); None where that is long."""
    period = record.scenario.control_period_s
    turned_on = [0, *(end for _, end in _restarts(record))]
    since = min((place - begin for begin in turned_on if begin <= place), default=TAKE_OVER_PERIODS)
    return since * period if since < TAKE_OVER_PERIODS else None


def _restarts(record: DutyRecord) -> list[tuple[int, int]]:
    """List the control periods of the restarts of a run, and of the first ones after them whose answers can act."""
    period = record.scenario.control_period_s
    waiting = idle_bridge(record.declaration, period).waiting
    begins = [first_period_from(time, period) for time in record.scenario.restarts_s]
    return [(begin, begin + waiting) for begin in begins]


def peak_moment(record: DutyRecord) -> Moment:
    period, currents = record.scenario.control_period_s, record.run.column("peak_current")
    place, _, allowed = _decisive_peak(record)
    if place is None:
        place, allowed = len(currents) - 1, record.limits.peak_a
    return Moment(
        start_s=max(place - SHOWN_PERIODS, 0) * period,
        end_s=min(place + SHOWN_PERIODS, len(currents)) * period,
        column="peak_current_a",
        levels=(Mark(words=f"limit {allowed:.4g} A", value=allowed),),
        point=Point(
            words=f"{currents[place]:.4g} A", time_s=(place + 0.5) * period, value=float(currents[place])
        ),
    )


def _decisive_peak(record: DutyRecord) -> tuple[int | None, float, float]:
    """Find the control period whose peak is the greatest over its limit, with both (A); None if none is judged."""
    currents, allowed = record.run.column("peak_current"), _allowed_a(record)
    judged = np.flatnonzero(np.isfinite(allowed))
    if not judged.size:
        return None, 0.0, inf
    place = int(judged[np.argmax(currents[judged] / allowed[judged])])
    return place, float(currents[place]), float(allowed[place])


def _allowed_a(record: DutyRecord) -> NDArray[np.float64]:
    """Return the limit of the peak of each control period (A); infinite where no answer can act yet."""
    limits, scale = record.limits, record.scenario.scales.inductance
    link = record.run.column("link")
    # More ripple than the stated one comes from a higher link, or from less inductance.
    ripple = float(np.max(link, initial=0.0)) / record.document.inverter.link_voltage_v / scale
    allowed = _rise_by_link_steps(record) + (limits.peak_a + limits.peak_ripple_a * max(ripple - 1.0, 0.0))
    allowed[: _first_judged(record)] = inf
    for begin, end in _restarts(record):
        if begin < end < len(link) and _rectifies_at(record, end):
            allowed[begin : end + TAKE_OVER_PERIODS] = inf
    allowed[_locking(record)] = inf
    return allowed


def _rise_by_link_steps(record: DutyRecord) -> NDArray[np.float64]:
    """Return by how much steps of the link raise a current before an answer acts, until it is brought back (A).

    Until then the duty ratios are those for the link before the step.
    """
    link, period = record.run.column("link"), record.scenario.control_period_s
    unanswered = record.document.inverter.update_delay * period
    steps = np.abs(np.diff(link, prepend=link[:1]))
    if unanswered == 0.0 or not steps.any():
        return np.zeros(len(link))
    asked = np.divide(record.run.voltages, link, out=np.zeros(len(link)), where=link > 0.0)
    # The answer to the sample before the step acts in the period that begins with it.
    asked[1:] = asked[:-1].copy()
    machine = record.document.machine
    inductance = record.scenario.scales.inductance * min(
        machine.direct_inductance_h, machine.quadrature_inductance_h
    )
    at_steps = asked * steps * unanswered / inductance
    # No step is greater than the voltage that brings the current back.
    periods = ceil((unanswered + _return_s(record, unanswered)) / period)
    rise = at_steps.copy()
    for later in range(1, min(periods, len(link))):
        np.maximum(rise[later:], at_steps[:-later], out=rise[later:])
    return rise


def _return_s(record: DutyRecord, voltage_time_s: float) -> float:
    """Return the time to bring a current back, of which all of the voltage takes a part (s)."""
    bandwidth = record.declaration.current_bandwidth
    if bandwidth is None:
        return float(record.limits.rise_time_s + voltage_time_s)
    return declared_rise_s(record.document, bandwidth, voltage_time=voltage_time_s)


def _first_judged(record: DutyRecord) -> int:
    """Return the first control period whose current is the controller's doing."""
    first = record.document.inverter.update_delay
    # Diodes rectify with the voltage of six steps, which a controller without overmodulation cannot sustain.
    return first + TAKE_OVER_PERIODS if _rectifies_at(record, 0) else first


def _rectifies_at(record: DutyRecord, place: int) -> bool:
    """Return True if the diodes of a bridge that is off conduct at the start of a control period."""
    speed, link = (float(record.run.column(name)[place]) for name in ("speed", "link"))
    return bool(rectifies(record.plant, speed, link))


def _locking(record: DutyRecord) -> slice:
    """Return the control periods in which the current rises, and is brought back, after a shaft locks within one.

    The back-EMF is gone at once. The first sample that shows the current is a period later, and the answer to it acts
    after the delay. From then on the regulator has the time of a step, and what the link's voltage takes besides.
    """
    failure, period = record.scenario.failure, record.scenario.control_period_s
    if failure is None or failure.kind != "locked-rotor":
        return slice(0)
    begin = failure.first_period(period)
    if not 0 < begin < len(record.run.column("speed")):
        return slice(0)
    speed, link = (float(record.run.column(name)[begin - 1]) for name in ("speed", "link"))
    unanswered = (1 + record.document.inverter.update_delay) * period
    lost = steady_state(record.plant, speed, 0.0, 0.0).voltage
    back = _return_s(record, unanswered * lost / undistorted(record.plant, link))
    return slice(begin, begin + ceil((unanswered + back) / period))


def steady_current(record: DutyRecord) -> Margin | None:
    # Without a current that holds the voltage, the drive itself makes the controller exceed the limit.
    return worst(
        _steady_excess(record, window)
        for window in record.nominal
        if isfinite(greatest_required(record, window.speed, window.link))
    )


def _steady_excess(record: DutyRecord, window: DutyWindow) -> Margin:
    limit = record.document.rating.current_limit_a
    # A current below the limit is no better than one at the limit, where a controller must go for its torque.
    excess = max(window.current / limit - 1.0, 0.0)
    measured = f"{window.current:.5g} A, the limit is {limit:g} A, {at(window)}"
    return Margin("OVC-2", at_most(excess, STEADY_EXCESS), measured)


def least_current(record: DutyRecord) -> Margin | None:
    return worst(_current_excess(record, window) for window in record.nominal)


def _current_excess(record: DutyRecord, window: DutyWindow) -> Margin | None:
    if abs(window.torque) < LEAST_TORQUE_SHARE * record.document.rating.rated_torque_nm:
        return None
    least = least_free(record.plant, window.speed, window.torque)
    if not (isfinite(least.voltage) and least.voltage < FREE_SHARE * undistorted(record.plant, window.link)):
        return None
    excess = window.current / least.current - 1.0
    measured = f"{100.0 * excess:.3g} % above {least.current:.4g} A for {window.torque:.4g} N·m {at(window)}"
    # An angle that is off costs current.
    allowed = record.limits.current_excess + if_unsensed(record, LOST_SHARE)
    by_current = Margin("MTP-1", at_most(excess, allowed), measured)
    # More current is no waste where it saves more in the iron. What drops and switching lose grows with the current, so
    # that the least of all losses lies between the least current and the least loss of the fundamental.
    own, saving = losses(record, window)
    first, last = sorted((least.direct, saving.direct))
    wasted = 0.0 if first <= window.direct <= last else _above_least(own, saving)
    by_loss = at_most(wasted, allowed)
    return by_current if by_current.value >= by_loss else replace(by_current, value=by_loss)


def _above_least(own: SteadyState, least: SteadyState) -> float:
    """Return the loss of the fundamental over the least one for its torque, less one; 0 where none is known (1)."""
    return own.loss / least.loss - 1.0 if isfinite(least.loss) and least.loss > 0.0 else 0.0


def losses(record: DutyRecord, window: DutyWindow) -> tuple[SteadyState, SteadyState]:
    """Return the steady state of a window's currents, and that of least loss for its torque."""
    own = steady_state(record.plant, window.speed, window.direct, window.quadrature)
    return own, least_within(record.plant, window.speed, window.link, own.torque, "loss")


def least_loss(record: DutyRecord) -> Margin | None:
    return worst(_loss_excess(record, window) for window in efficiency_windows(record))


def efficiency_windows(record: DutyRecord) -> Iterator[DutyWindow]:
    base, rated = record.document.rating.base_speed_rpm, record.document.rating.rated_torque_nm
    for window in record.nominal if record.scenario.supply_v is None else ():
        if window.torque_reference is not None:
            at_speed, at_torque = window.dwell.speed_rpm / base, window.torque_reference / rated
            if any(abs(at_speed - s) < _SAME and abs(at_torque - t) < _SAME for s, t in EFFICIENCY_POINTS):
                yield window


def _loss_excess(record: DutyRecord, window: DutyWindow) -> Margin:
    excess = _above_least(*losses(record, window))
    measured = f"{100.0 * excess:.3g} % above the least loss for {window.torque:.4g} N·m {at(window)}"
    # The loss of a winding goes with the square of a current.
    allowed = record.limits.loss_excess + if_unsensed(record, 2.0 * LOST_SHARE)
    return Margin("EFF-1", at_most(excess, allowed), measured)


OVC_1 = Check(
    id="OVC-1",
    every_run=True,
    requirement=(
        "No phase current exceeds its peak limit and ideal ripple, whatever load, reference or supply do."
    ),
    limit="{peak} with {peak_ripple} of ripple",
    scenarios=(
        "every run from the control period in which the first answer acts, or 100 control periods later if the diodes "
        "conduct before; not while a current that rises as the shaft locks is brought back"
    ),
    formula="1 - greatest phase current / the limit",
    why="Devices and magnets are chosen for that current.",
    evaluate=peak_current,
    moment=peak_moment,
)
OVC_2 = Check(
    id="OVC-2",
    families=STEADY_FAMILIES,
    requirement=(
        "In steady state the amplitude of the current is at most 1 % above the limit of the nameplate."
    ),
    limit="1 % above {current}",
    scenarios="steady stretches of the nominal drive where some current within the limit meets the voltage",
    formula="1 - (amplitude of the fundamental / {current} - 1, at least 0) / 1 %",
    why="The drive is rated for that current; the higher peak limit is for transients alone.",
    evaluate=steady_current,
)
MTP_1 = Check(
    id="MTP-1",
    families=UNWEAKENED_FAMILIES,
    requirement=(
        "Below weakening the current is at most {current_excess} above the least for its torque, or the loss "
        "above the least loss, or the d current lies between both."
    ),
    limit="{current_excess} above the least",
    scenarios="steady stretches of nominal drives from 10 % of rated torque on that take 90 % of the voltage at most",
    formula="the greater of 1 - (current / the oracle's least - 1) / {current_excess} and the same of the loss of the "
    "fundamental; 1 for a d current between the two oracles', where drops and switching put the least of all losses",
    why="More current than the least heats the winding for nothing, unless it saves loss in the iron.",
    evaluate=least_current,
    reason_not_applicable=unless_current,
)
EFF_1 = Check(
    id="EFF-1",
    requirement=(
        "At eight operating points derived from those of IEC 61800-9-2 the loss is at most {loss_excess} "
        "above the least possible."
    ),
    level="advisory",
    limit="{loss_excess} above the least loss",
    scenarios="steady torque at 0, 50 and 100 % of base speed, 25, 50 and 100 % of rated torque, on the nominal drive",
    formula="1 - (loss of the fundamental / the oracle's least loss - 1) / {loss_excess}",
    why="Least current is not least loss where the iron loses too.",
    evaluate=least_loss,
    reason_not_applicable=unless_current,
)
