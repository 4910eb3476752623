"""Advance of machine, bridge and a link with a capacitor over one control period at constant speed."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import called, inlined, unallocating
from drivegate_models.machine import ledger
from drivegate_models.machine.advance_status import COMPLETED, TOO_MANY_EVENTS
from drivegate_models.machine.rotor_frame import RotorFrame, phase_current
from drivegate_models.machine.sine import cosine_sine
from drivegate_models.pm_ac.plant.advance import (
    EVENT_LIMIT,
    LEAST_SHARE,
    NO_LEG,
    SHORT_SHARE,
    SOON_AFTER,
    Connected,
    PmAcPhases,
    add_core_loss,
    after_event,
    begin_observation,
    finish,
    pass_without_current,
    stator_flux,
)
from drivegate_models.pm_ac.plant.circuit import (
    Circuit,
    drop_of,
    is_on_upper_rail,
    leg_voltages,
    phase_slope,
    sagitta,
)
from drivegate_models.pm_ac.plant.dc_link import (
    BATTERY,
    CHOPPER,
    CLAMPED,
    CURRENT,
    FLUX,
    PENDING,
    RESISTED,
    SOURCE,
    THROUGHPUT,
    VOLTAGE,
    DcLink,
    LinkState,
)
from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.pm_ac.plant.edges import begin_schedule, pass_before, pass_edges, sooner
from drivegate_models.pm_ac.plant.events import NOTHING, Event, zero_of_current
from drivegate_models.pm_ac.plant.linked_events import (
    LinkEvent,
    begin_of_linked_current,
    end_of_linked_hold,
    enter_link_event,
    link_event,
)
from drivegate_models.pm_ac.plant.linked_integrals import add_linked_segment
from drivegate_models.pm_ac.plant.linked_period import pass_linked_segments
from drivegate_models.pm_ac.plant.linked_propagation import keeps_sign
from drivegate_models.pm_ac.plant.linked_series import (
    Feed,
    at_voltage,
    bend_of,
    free_linked_series,
    held_linked_series,
    idle_series,
    linked_circuit,
    linked_end,
    longest_linked,
)
from drivegate_models.pm_ac.plant.modulator import Gates, schedule_gates
from drivegate_models.pm_ac.plant.polynomial import value_at
from drivegate_models.pm_ac.plant.series import shorten, shorten_both, shorten_one
from drivegate_models.pm_ac.plant.settling import EMPTY, FREE, Legs, settle, show_voltages
from drivegate_models.pm_ac.plant.volt_seconds import add_volt_seconds, is_followed

_LEAST_SUPPLYING: Final = 0.2
"""Voltage over the nominal one below which the link supplies core and switching losses only in part (1)."""


@inlined
def _connect_source(constants: DcLink, link: LinkState, source: float) -> None:
    """Connect or disconnect the source at the start of a period; at 0 V it is disconnected.

    The switch that does it takes the energy of the source's inductance.
    """
    state = link.state
    current = state[CURRENT]
    takes = constants.source == BATTERY or current > 0.0 or state[VOLTAGE] <= source
    conducts = source > 0.0 and takes
    state[SOURCE] = 1.0 if conducts else 0.0
    if not conducts and current != 0.0:
        broken = 0.5 * constants.source_inductance * current * current
        link.totals[RESISTED] += broken
        link.totals[THROUGHPUT] += broken
        state[CURRENT] = 0.0


@inlined
def _feed(constants: DcLink, link: LinkState, source: float, lost: float) -> Feed:
    """Return what acts on the capacitor now; `lost` is the conductance of core and switching losses (S)."""
    state = link.state
    chopper = constants.chopper_conductance if state[CHOPPER] != 0.0 else 0.0
    conducts = state[SOURCE] != 0.0
    is_inductive = constants.source_inductance > 0.0
    return Feed(
        source,
        1.0 / constants.source_resistance if conducts and not is_inductive else 0.0,
        lost + chopper,
        0.0 if state[CLAMPED] != 0.0 else 1.0 / constants.capacitance,
        1.0 / constants.source_inductance if conducts and is_inductive else 0.0,
        constants.source_resistance,
    )


@inlined
def _end_link(feed: Feed, link: LinkState, count: int) -> None:
    """Set the link to the end of a segment, of which the series are known."""
    link.state[VOLTAGE] = value_at(link.voltage, count, 1.0)
    if feed.per_inductance != 0.0:
        link.state[CURRENT] = value_at(link.source, count, 1.0)


@inlined
def _end_braking(link: LinkState, end: float, time: float) -> float:
    """Turn a commanded chopper off at the end of its time (s); return that end, 0 once it is over."""
    if not 0.0 < end <= time:
        return end
    link.state[CHOPPER] = 0.0
    return 0.0


@inlined
def _follow_link(circuit: Circuit, legs: Legs, voltage: float) -> Circuit:
    """Set the legs' voltages to a new link voltage (V); return the circuit with it."""
    circuit = at_voltage(circuit, voltage, circuit.bend)
    for leg in range(3):
        legs.low[leg], legs.high[leg] = leg_voltages(circuit, legs.gates[leg])
    return circuit


@inlined
def _changing_edge(circuit: Circuit, legs: Legs, gates: Gates, leg: int, sign: int) -> int:
    """Return the number of the next edge that changes a leg's rail or device at a sign of its current, 0 for either."""
    gate = legs.gates[leg]
    following = legs.positions[leg] + 1
    while following < gates.counts[leg] and sign != 0:
        entry = gates.gates[leg, following]
        is_same_rail = is_on_upper_rail(entry, sign) == is_on_upper_rail(gate, sign)
        if not is_same_rail or drop_of(circuit, entry, sign) != drop_of(circuit, gate, sign):
            break
        following += 1
    return int(following)


@inlined
def _next_edge(circuit: Circuit, legs: Legs, gates: Gates, duration: float) -> float:
    """Pass the edges without effect, and return the time of the next change of a leg by its gate (s).

    A leg with a sure sign changes if its rail or its device does, whatever the link's voltage is.
    """
    limit = duration
    for leg in range(3):
        following = _changing_edge(circuit, legs, gates, leg, legs.sure[leg])
        pass_before(circuit, legs, gates, leg, following)
        limit = sooner(gates, leg, following, limit)
    return limit


# Called once, and inlined: a call would pass every array of `phases` on the stack, which costs as much as a series.
@inlined
def _first_events(
    drive: PmAcDrive,
    circuit: Circuit,
    feed: Feed,
    phases: PmAcPhases,
    frame: RotorFrame,
    held: int,
    end_angle: float,
    length: float,
    follows_thresholds: bool,
) -> tuple[Circuit, Event, LinkEvent, int, RotorFrame]:
    """Write the series of a segment, and find its first events.

    Returns the circuit with the bound of the series, the events of legs and link, the number of coefficients, and the
    currents without an event.
    """
    legs, series, link = phases.legs, phases.series, phases.dc_link
    cosine, sine = cosine_sine(end_angle)
    after = RotorFrame(0.0, 0.0, cosine, sine)
    if held == EMPTY:
        count = idle_series(circuit, feed, link, length)
        event = begin_of_linked_current(circuit, legs, series, link, frame, count, length)
    elif held == FREE:
        count = free_linked_series(circuit, feed, legs, series, link, frame, length)
        after = linked_end(series, count, cosine, sine)
        circuit = at_voltage(circuit, circuit.link, bend_of(series, count, length))
        event = zero_of_current(circuit, legs, series, frame, after, count, length, True)
    else:
        count = held_linked_series(circuit, feed, legs, series, link, frame, held, length)
        after = linked_end(series, count, cosine, sine)
        event = end_of_linked_hold(legs, series, link, held, count)
    return (
        circuit,
        event,
        link_event(drive, link, feed.source, count, follows_thresholds),
        count,
        after,
    )


@inlined
def _segment(
    drive: PmAcDrive,
    circuit: Circuit,
    feed: Feed,
    phases: PmAcPhases,
    frame: RotorFrame,
    held: int,
    begin_angle: float,
    length: float,
    follows_thresholds: bool,
    totals: NDArray[np.float64],
) -> tuple[Event, int, float, RotorFrame]:
    """Advance to the first event within a length (s), and set the link's voltage there.

    Returns the event of the legs, the kind of that of the link, of which at most one is other than `NOTHING`, the time
    until then (s), and the currents.
    """
    link, series = phases.dc_link, phases.series
    electrical = circuit.electrical
    while True:
        bounded, event, change, count, after = _first_events(
            drive,
            circuit,
            feed,
            phases,
            frame,
            held,
            begin_angle + electrical * length,
            length,
            follows_thresholds,
        )
        if not LEAST_SHARE < min(event.share, change.share) < SHORT_SHARE:
            break
        length *= SOON_AFTER * min(event.share, change.share)
    kind = change.kind
    whole = length
    begin = link.state[VOLTAGE]
    share = event.share
    if kind != NOTHING and (event.kind == NOTHING or change.share < event.share):
        share = change.share
        event = Event(NOTHING, 1.0, -1, 0)
    else:
        kind = NOTHING
    if event.kind != NOTHING or kind != NOTHING:
        length *= share
        cosine, sine = cosine_sine(begin_angle + electrical * length)
        shorten_both(link.voltage, link.bridge, count, share)
        if feed.per_inductance != 0.0:
            shorten_one(link.source, count, share)
        after = RotorFrame(0.0, 0.0, cosine, sine)
        if held != EMPTY:
            shorten(series, count, share)
            after = linked_end(series, count, cosine, sine)
    before = link.totals[FLUX]
    if length > 0.0:
        add_linked_segment(
            drive,
            bounded,
            feed,
            phases.legs,
            series,
            link,
            frame,
            after,
            held,
            count,
            length,
            phases.magnitudes,
            phases.torque_bounds,
            totals,
        )
    if is_followed(phases.volt_seconds):
        passed = 1.0 if length == whole else share
        rise = link.totals[FLUX] - before - begin * length
        add_volt_seconds(
            circuit, phases.legs, series, frame, held, count, whole, passed, rise, phases.volt_seconds
        )
    _end_link(feed, link, count)
    enter_link_event(link, kind)
    return event, kind, length, after


@inlined
def observes_sums_alone(phases: PmAcPhases) -> bool:
    """Return True if neither the extremes of the torque nor the voltages of the terminals are computed."""
    return phases.torque_bounds.size == 0 and not is_followed(phases.volt_seconds)


@inlined
def _distant_edge(circuit: Circuit, legs: Legs, gates: Gates, duration: float) -> float:
    """Return the time of the next change of a leg's rail or device, if no current changes its sign (s)."""
    limit = duration
    for leg in range(3):
        following = _changing_edge(circuit, legs, gates, leg, legs.signs[leg])
        limit = sooner(gates, leg, following, limit)
    return limit


@inlined
def _heads_for_zero(circuit: Circuit, legs: Legs, frame: RotorFrame, length: float) -> bool:
    """Return True if a current without a sure sign would reach zero within a length (s) at its present slope."""
    voltages = legs.voltages
    for leg in range(3):
        if legs.sure[leg] == 0:
            slope = phase_slope(circuit, frame, leg, voltages[0], voltages[1], voltages[2])
            if legs.signs[leg] * (phase_current(frame, leg) + slope * length) <= 0.0:
                return True
    return False


@unallocating
def _pass_quietly(
    drive: PmAcDrive,
    circuit: Circuit,
    feed: Feed,
    phases: PmAcPhases,
    frame: RotorFrame,
    begin_angle: float,
    length: float,
    follows_thresholds: bool,
    totals: NDArray[np.float64],
) -> tuple[bool, RotorFrame]:
    """Advance by a length (s) over edges without effect, if no current changes its sign and nothing else happens.

    Returns whether that is so, and the currents; otherwise nothing has been changed.
    """
    legs, series, link = phases.legs, phases.series, phases.dc_link
    if _heads_for_zero(circuit, legs, frame, length):
        return False, frame
    cosine, sine = cosine_sine(begin_angle + circuit.electrical * length)
    count = free_linked_series(circuit, feed, legs, series, link, frame, length)
    after = linked_end(series, count, cosine, sine)
    bounded = at_voltage(circuit, circuit.link, bend_of(series, count, length))
    deviation = sagitta(bounded, length)
    for leg in range(3):
        before, end = phase_current(frame, leg), phase_current(after, leg)
        if legs.sure[leg] == 0 and not keeps_sign(legs.signs[leg], before, end, deviation):
            return False, frame
    if link_event(drive, link, feed.source, count, follows_thresholds).kind != NOTHING:
        return False, frame
    before = link.totals[FLUX]
    add_linked_segment(
        drive,
        bounded,
        feed,
        legs,
        series,
        link,
        frame,
        after,
        FREE,
        count,
        length,
        phases.magnitudes,
        phases.torque_bounds,
        totals,
    )
    if is_followed(phases.volt_seconds):
        rise = link.totals[FLUX] - before - link.state[VOLTAGE] * length
        add_volt_seconds(circuit, legs, series, frame, FREE, count, length, 1.0, rise, phases.volt_seconds)
    _end_link(feed, link, count)
    return True, after


@called
@unallocating
def advance_linked_period(
    drive: PmAcDrive,
    phases: PmAcPhases,
    angle: float,
    speed: float,
    source: float,
    ratios: NDArray[np.float64],
    legs_mode: NDArray[np.int64],
    brake: float,
    alignment: int,
    duration: float,
    totals: NDArray[np.float64],
) -> int:
    """Advance machine, bridge and link by one control period, solving every event in it.

    As `advance.advance_period`, for a link with a capacitor.

    - `phases`: its `dc_link` is updated as well; its ledger is added to.
    - `source`: voltage of the source (V); 0 disconnects it.
    - `brake`: share of the period with the chopper on, from its start (1); NaN for the chopper's own thresholds.
    - Result: `COMPLETED` or `TOO_MANY_EVENTS`.
    """
    legs, gates, link = phases.legs, phases.gates, phases.dc_link
    constants = drive.dc_link
    state = link.state
    cosine, sine = cosine_sine(angle)
    frame = RotorFrame(phases.rotor_currents[0], phases.rotor_currents[1], cosine, sine)
    voltage = state[VOLTAGE]
    supplying = max(voltage, _LEAST_SUPPLYING * drive.link_voltage)
    lost = state[PENDING] / (supplying * supplying)
    follows_thresholds = brake != brake
    brake_end = 0.0
    if not follows_thresholds:
        brake_end = min(max(brake, 0.0), 1.0) * duration if constants.chopper_conductance > 0.0 else 0.0
        state[CHOPPER] = 1.0 if brake_end > 0.0 else 0.0
    _connect_source(constants, link, source)
    circuit = linked_circuit(
        drive,
        speed,
        voltage,
        source,
        state[CURRENT],
        (frame.direct, frame.quadrature),
        lost + constants.chopper_conductance,
        duration,
    )
    begin_observation(phases)
    schedule_gates(drive.modulator, gates, ratios, legs_mode, alignment, duration)
    circuit = _follow_link(circuit, legs, voltage)
    totals[ledger.SWITCHING] += begin_schedule(circuit, legs, gates, frame, duration)
    along, across = stator_flux(circuit, frame)
    idle = 0.0
    status = COMPLETED
    time = 0.0
    segments = 0
    settled = settle(circuit, legs, frame, NO_LEG, 0)
    is_steady = constants.source_inductance == 0.0 and (brake_end == 0.0 or brake_end == duration)
    passes_many = is_steady and observes_sums_alone(phases)
    while time < duration:
        segments += 1
        if segments > EVENT_LIMIT:
            status = TOO_MANY_EVENTS
            break
        held = settled.held
        frame = settled.frame
        feed = _feed(constants, link, source, lost)
        far = _distant_edge(circuit, legs, gates, duration) if held == FREE else time
        if passes_many and far > time and not _heads_for_zero(circuit, legs, frame, far - time):
            count, time, after = pass_linked_segments(
                drive, circuit, feed, phases, frame, time, duration, follows_thresholds, totals
            )
            if count > 0:
                segments += count - 1
                circuit = _follow_link(circuit, legs, state[VOLTAGE])
                brake_end = _end_braking(link, brake_end, time)
                totals[ledger.SWITCHING] += pass_edges(circuit, legs, gates, time)
                settled = settle(circuit, legs, after, NO_LEG, 0)
                continue
        longest = longest_linked(circuit, held, duration)
        limit = _next_edge(circuit, legs, gates, duration)
        end = brake_end if time < brake_end else duration
        if held == FREE and not passes_many:
            far = min(far, end, time + longest)
            if far > limit:
                is_quiet, after = _pass_quietly(
                    drive,
                    circuit,
                    feed,
                    phases,
                    frame,
                    angle + circuit.electrical * time,
                    far - time,
                    follows_thresholds,
                    totals,
                )
                if is_quiet:
                    time = far
                    circuit = _follow_link(circuit, legs, state[VOLTAGE])
                    brake_end = _end_braking(link, brake_end, time)
                    totals[ledger.SWITCHING] += pass_edges(circuit, legs, gates, time)
                    settled = settle(circuit, legs, after, NO_LEG, 0)
                    continue
        limit = min(limit, end)
        length = min(limit - time, longest)
        event, kind, passed, after = _segment(
            drive,
            circuit,
            feed,
            phases,
            frame,
            held,
            angle + circuit.electrical * time,
            length,
            follows_thresholds,
            totals,
        )
        is_whole = event.kind == NOTHING and kind == NOTHING and limit - time <= longest and passed == length
        time += passed
        if held == EMPTY:
            turned = pass_without_current(phases, circuit, frame, after)
            along += turned[0]
            across += turned[1]
            idle += passed
        after, fixed, excluded = after_event(legs, event, after)
        circuit = _follow_link(circuit, legs, state[VOLTAGE])
        if is_whole:
            # Use the limit itself, not the sum, so that every edge is passed exactly once.
            time = limit
            brake_end = _end_braking(link, brake_end, time)
            totals[ledger.SWITCHING] += pass_edges(circuit, legs, gates, time)
        settled = settle(circuit, legs, after, fixed, excluded)
    flux = stator_flux(circuit, settled.frame)
    add_core_loss(drive, circuit, Connected(flux[0] - along, flux[1] - across, idle), duration, totals)
    finish(phases, settled.frame)
    show_voltages(circuit, legs, settled)
    totals[ledger.EVENTS] += segments
    return status
