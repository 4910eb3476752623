"""Advance of machine and bridge over one control period at constant speed and link voltage, from event to event."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import called, inlined, unallocating
from drivegate_models.machine import ledger
from drivegate_models.machine.advance_status import COMPLETED, TOO_MANY_EVENTS
from drivegate_models.machine.rotor_frame import RotorFrame, phase_current
from drivegate_models.machine.sine import cosine_sine
from drivegate_models.pm_ac.plant.circuit import Circuit, circuit_of, rotor_voltages
from drivegate_models.pm_ac.plant.dc_link import LinkState, make_link_state
from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.pm_ac.plant.edges import begin_schedule, distant_edge, next_edge, pass_edges
from drivegate_models.pm_ac.plant.events import (
    LAST_ZERO,
    NOTHING,
    ONSET,
    RELEASE,
    ZERO,
    Event,
    begin_of_current,
    end_of_hold,
    zero_of_current,
)
from drivegate_models.pm_ac.plant.integrals import add_segment
from drivegate_models.pm_ac.plant.jets import rates_of
from drivegate_models.pm_ac.plant.modulator import BLANKED, Gates, make_gates, schedule_gates
from drivegate_models.pm_ac.plant.pattern import Upcoming, make_upcoming
from drivegate_models.pm_ac.plant.quiet import pass_quietly
from drivegate_models.pm_ac.plant.quiet_period import LONGEST_PERIOD, pass_period
from drivegate_models.pm_ac.plant.rows import make_rows
from drivegate_models.pm_ac.plant.series import (
    TERMS,
    Series,
    at_end,
    free_series,
    held_series,
    longest_segment,
    make_series,
    shorten,
)
from drivegate_models.pm_ac.plant.settling import (
    EMPTY,
    FREE,
    Legs,
    Settled,
    make_legs,
    set_gate,
    settle,
    show_voltages,
)
from drivegate_models.pm_ac.plant.two_points import SHORT
from drivegate_models.pm_ac.plant.volt_seconds import add_steady, add_volt_seconds, is_followed

EVENT_LIMIT: Final = 100_000
"""Maximum number of segments in one advance."""

# An event earlier than this share of the segment is searched again in a segment that ends soon after it.
SHORT_SHARE: Final = 1e-2
SOON_AFTER: Final = 4.0
LEAST_SHARE: Final = 1e-14
# Number of terms in the series of a rotation over the longest segment.
_TURNING_TERMS = 14
NO_LEG: Final = -1


class PmAcPhases(NamedTuple):
    """State of machine, bridge and modulator; the arrays are updated in place."""

    rotor_currents: NDArray[np.float64]
    """d-axis and q-axis currents, shape (2,) (A)."""
    currents: NDArray[np.float64]
    """Phase currents at the end of the last advance, shape (3,) (A)."""
    magnitudes: NDArray[np.float64]
    """Integral of each phase's current magnitude over the last advance, shape (3,) (A s)."""
    torque_bounds: NDArray[np.float64]
    """Minimum and maximum torque of the last advance (N m), shape (2,); shape (0,) to compute none."""
    gates: Gates
    """Modulators and their schedule."""
    legs: Legs
    """Signs and voltages of the legs; the signs are part of the state."""
    series: Series
    """Work space for the series of a segment."""
    upcoming: Upcoming
    """Work space for the legs in a quiet period."""
    rows: NDArray[np.float64]
    """Work space for the segments of a quiet period, as in `plant.rows`."""
    dc_link: LinkState
    """State of the link, unless it is ideal."""
    volt_seconds: NDArray[np.float64]
    """Integrals of the terminals' voltages to the lower rail, shape (3,) (V s), which every advance adds to; shape (0,)
    to compute none."""


class Connected(NamedTuple):
    """Quantities for the core loss, from the part of an advance in which current can flow."""

    along: float
    """Change of the stator's flux linkage along the first phase's axis (V s)."""
    across: float
    """Change of the stator's flux linkage across the first phase's axis (V s)."""
    idle: float
    """Time without any current (s)."""


def make_phases(*, follows_torque: bool = False, follows_voltages: bool = False) -> PmAcPhases:
    """Return a machine without current, with modulators that have commanded the lower switches.

    `follows_torque`: true to compute the extremes of the torque in each advance. `follows_voltages`: true to integrate
    the voltages of the terminals.
    """
    volt_seconds = np.zeros(3 if follows_voltages else 0)
    return PmAcPhases(
        np.zeros(2),
        np.zeros(3),
        np.zeros(3),
        np.zeros(2 if follows_torque else 0),
        make_gates(),
        make_legs(),
        make_series(),
        make_upcoming(volt_seconds),
        make_rows(),
        make_link_state(TERMS),
        volt_seconds,
    )


@inlined
def release_legs(drive: PmAcDrive, phases: PmAcPhases, angle: float, speed: float, link: float) -> None:
    """Turn all legs of a machine without current off, and show the voltages of its terminals."""
    cosine, sine = cosine_sine(angle)
    circuit = circuit_of(drive, speed, link, 0.0, 0.0, 0.0)
    for leg in range(3):
        set_gate(circuit, phases.legs, leg, BLANKED)
    show_voltages(circuit, phases.legs, Settled(EMPTY, RotorFrame(0.0, 0.0, cosine, sine)))


@inlined
def stored_energy(drive: PmAcDrive, phases: PmAcPhases) -> float:
    """Return the energy of the currents in the windings (J)."""
    direct = phases.rotor_currents[0]
    quadrature = phases.rotor_currents[1]
    along = drive.direct_inductance * direct * direct
    across = drive.quadrature_inductance * quadrature * quadrature
    return float(0.75 * (along + across))


@inlined
def stator_flux(circuit: Circuit, frame: RotorFrame) -> tuple[float, float]:
    """Return the flux linkage along and across the first phase's axis (V s)."""
    direct = circuit.direct * frame.direct + circuit.flux
    quadrature = circuit.quadrature * frame.quadrature
    return (
        frame.cosine * direct - frame.sine * quadrature,
        frame.sine * direct + frame.cosine * quadrature,
    )


@inlined
def after_event(legs: Legs, event: Event, frame: RotorFrame) -> tuple[RotorFrame, int, int]:
    """Set the signs after an event; return the currents, the leg with a known sign, and the excluded sign."""
    if event.kind == RELEASE:
        legs.signs[event.leg] = event.sign
        return frame, event.leg, 0
    if event.kind == ZERO:
        legs.signs[event.leg] = 0
        return frame, NO_LEG, event.sign
    if event.kind in (LAST_ZERO, ONSET):
        for leg in range(3):
            legs.signs[leg] = 0
        return RotorFrame(0.0, 0.0, frame.cosine, frame.sine), NO_LEG, 0
    return frame, NO_LEG, 0


@inlined
def _first_event(
    circuit: Circuit, phases: PmAcPhases, frame: RotorFrame, held: int, end_angle: float, length: float
) -> tuple[Event, int, RotorFrame]:
    """Write the series of a segment; return its first event, number of coefficients, and end without an event."""
    legs = phases.legs
    series = phases.series
    cosine, sine = cosine_sine(end_angle)
    if held == EMPTY:
        event = begin_of_current(circuit, legs, series, frame, _TURNING_TERMS, length)
        return event, 0, RotorFrame(0.0, 0.0, cosine, sine)
    if held == FREE:
        voltages = legs.voltages
        direct, quadrature = rotor_voltages(frame, voltages[0], voltages[1], voltages[2])
        count = free_series(circuit, series, frame, direct, quadrature, length)
        after = at_end(series, count, cosine, sine)
        return zero_of_current(circuit, legs, series, frame, after, count, length, False), count, after
    count = held_series(circuit, series, frame, held, legs.voltages, length)
    return end_of_hold(legs, series, held, count), count, at_end(series, count, cosine, sine)


# Called once, and inlined: a call would pass every array of `phases` on the stack.
@inlined
def _segment(
    drive: PmAcDrive,
    circuit: Circuit,
    phases: PmAcPhases,
    frame: RotorFrame,
    held: int,
    angle: float,
    time: float,
    length: float,
    totals: NDArray[np.float64],
) -> tuple[Event, float, RotorFrame]:
    """Advance to the first event within a length (s); return it, the time until then (s) and the currents."""
    begin_angle = angle + circuit.electrical * time
    electrical = circuit.electrical
    event, count, after = _first_event(
        circuit, phases, frame, held, begin_angle + electrical * length, length
    )
    while LEAST_SHARE < event.share < SHORT_SHARE:
        # The event is so early that the scale of the whole segment differs from that of its currents.
        length *= SOON_AFTER * event.share
        event, count, after = _first_event(
            circuit, phases, frame, held, begin_angle + electrical * length, length
        )
    series = phases.series
    if is_followed(phases.volt_seconds):
        share = event.share if event.kind != NOTHING else 1.0
        add_volt_seconds(
            circuit, phases.legs, series, frame, held, count, length, share, 0.0, phases.volt_seconds
        )
    if event.kind != NOTHING:
        length *= event.share
        cosine, sine = cosine_sine(begin_angle + electrical * length)
        shorten(series, count, event.share)
        after = RotorFrame(0.0, 0.0, cosine, sine) if held == EMPTY else at_end(series, count, cosine, sine)
    if length > 0.0 and held != EMPTY:
        add_segment(
            drive,
            circuit,
            phases.legs,
            series,
            frame,
            after,
            held,
            count,
            length,
            phases.magnitudes,
            phases.torque_bounds,
            totals,
        )
    return event, length, after


@inlined
def add_core_loss(
    drive: PmAcDrive, circuit: Circuit, connected: Connected, duration: float, totals: NDArray[np.float64]
) -> None:
    """Add the core loss by the mean flux voltage; without any current the shaft supplies it."""
    if drive.core_loss_conductance == 0.0:
        return
    conductance = 1.5 * drive.core_loss_conductance
    length = duration - connected.idle
    if length > 0.0:
        square = connected.along * connected.along + connected.across * connected.across
        totals[ledger.CORE_SOURCE] += conductance * square / length
    # This is power over speed, without a division by the speed.
    totals[ledger.CORE_DRAG_IMPULSE] += (
        conductance * circuit.flux * circuit.flux * circuit.electrical * drive.pole_pairs * connected.idle
    )


@inlined
def finish(phases: PmAcPhases, frame: RotorFrame) -> None:
    """Store the state at the end of an advance."""
    phases.rotor_currents[0] = frame.direct
    phases.rotor_currents[1] = frame.quadrature
    for leg in range(3):
        phases.currents[leg] = phase_current(frame, leg)


@inlined
def pass_without_current(
    phases: PmAcPhases, circuit: Circuit, frame: RotorFrame, after: RotorFrame
) -> tuple[float, float]:
    """Observe a stretch without a current, whose torque is 0, and return the change of the stator flux in it (V s)."""
    before = stator_flux(circuit, frame)
    behind = stator_flux(circuit, after)
    if phases.torque_bounds.size > 0:
        phases.torque_bounds[0] = min(phases.torque_bounds[0], 0.0)
        phases.torque_bounds[1] = max(phases.torque_bounds[1], 0.0)
    return behind[0] - before[0], behind[1] - before[1]


@inlined
def begin_observation(phases: PmAcPhases) -> None:
    """Reset the observations of the last advance."""
    for leg in range(3):
        phases.magnitudes[leg] = 0.0
    if phases.torque_bounds.size > 0:
        phases.torque_bounds[0] = np.inf
        phases.torque_bounds[1] = -np.inf


@inlined
def advance_period(
    drive: PmAcDrive,
    phases: PmAcPhases,
    angle: float,
    speed: float,
    link: float,
    ratios: NDArray[np.float64],
    legs_mode: NDArray[np.int64],
    alignment: int,
    duration: float,
    totals: NDArray[np.float64],
) -> int:
    """Advance machine and bridge by one control period, solving every event in it.

    - `phases`: state before the advance; replaced by the state after it.
    - `angle`: electrical angle of the d axis at the start (rad).
    - `speed`: shaft speed, of either sign (rad/s).
    - `link`: voltage of the dc link, at least 0 (V).
    - `ratios`, shape (3,): duty ratios that act in this period (1).
    - `legs_mode`, shape (3,): `LEG_OFF`, `LEG_PWM`, `LEG_HIGH` or `LEG_LOW` of the contract for each leg.
    - `alignment`: `drive.CENTRED`, `RISING` or `FALLING`.
    - `duration`: length of the advance (s).
    - `totals`, shape (ledger.ENTRIES,): the exact integrals are added to it; both halves of the link have equal shares.
    - Result: `COMPLETED` or `TOO_MANY_EVENTS`.
    """
    legs = phases.legs
    gates = phases.gates
    cosine, sine = cosine_sine(angle)
    frame = RotorFrame(phases.rotor_currents[0], phases.rotor_currents[1], cosine, sine)
    circuit = circuit_of(drive, speed, link, frame.direct, frame.quadrature, duration)
    begin_observation(phases)
    schedule_gates(drive.modulator, gates, ratios, legs_mode, alignment, duration)
    totals[ledger.SWITCHING] += begin_schedule(circuit, legs, gates, frame, duration)
    along, across = stator_flux(circuit, frame)
    rates = rates_of(circuit)
    # The extremes of the torque are computed from its series, which a quiet segment does not have.
    quiet_length = 0.0
    if phases.torque_bounds.size == 0:
        quiet_length = SHORT / circuit.rate if circuit.rate * duration > SHORT else duration
    idle = 0.0
    status = COMPLETED
    time = 0.0
    segments = 0
    settled = settle(circuit, legs, frame, NO_LEG, 0)
    if settled.held == FREE and quiet_length > 0.0 and circuit.rate * duration <= LONGEST_PERIOD:
        segments, after = pass_period(
            drive.pole_pairs,
            circuit,
            rates,
            legs,
            gates,
            phases.upcoming,
            settled.frame,
            duration,
            phases.series,
            phases.rows,
            phases.magnitudes,
            totals,
        )
        if segments > 0:
            time = duration
            add_steady(phases.upcoming.volt_seconds, 1.0, phases.volt_seconds)
            totals[ledger.SWITCHING] += pass_edges(circuit, legs, gates, time)
            settled = settle(circuit, legs, after, NO_LEG, 0)
    while time < duration:
        segments += 1
        if segments > EVENT_LIMIT:
            status = TOO_MANY_EVENTS
            break
        held = settled.held
        frame = settled.frame
        limit = time
        after = frame
        fixed = NO_LEG
        excluded = 0
        is_whole = False
        if held == FREE and quiet_length > 0.0:
            limit = min(distant_edge(circuit, legs, gates, duration), time + quiet_length)
            is_whole, after = pass_quietly(
                drive.pole_pairs, circuit, rates, legs, frame, limit - time, phases.magnitudes, totals
            )
            add_steady(legs.voltages, limit - time if is_whole else 0.0, phases.volt_seconds)
        if not is_whole:
            limit = next_edge(circuit, legs, gates, duration)
            longest = longest_segment(circuit, held, duration)
            length = min(limit - time, longest)
            event, passed, after = _segment(drive, circuit, phases, frame, held, angle, time, length, totals)
            is_whole = event.kind == NOTHING and limit - time <= longest and passed == length
            time += passed
            if held == EMPTY:
                turned = pass_without_current(phases, circuit, frame, after)
                along += turned[0]
                across += turned[1]
                idle += passed
            after, fixed, excluded = after_event(legs, event, after)
        if is_whole:
            # Use the limit itself, not the sum, so that every edge is passed exactly once.
            time = limit
            totals[ledger.SWITCHING] += pass_edges(circuit, legs, gates, time)
        settled = settle(circuit, legs, after, fixed, excluded)
    end = stator_flux(circuit, settled.frame)
    add_core_loss(drive, circuit, Connected(end[0] - along, end[1] - across, idle), duration, totals)
    finish(phases, settled.frame)
    show_voltages(circuit, legs, settled)
    totals[ledger.EVENTS] += segments
    return status


@called
@unallocating
def follow_period(
    drive: PmAcDrive,
    phases: PmAcPhases,
    angle: float,
    speed: float,
    link: float,
    ratios: NDArray[np.float64],
    legs_mode: NDArray[np.int64],
    alignment: int,
    duration: float,
    totals: NDArray[np.float64],
) -> int:
    """Advance as `advance_period` does. The closed loop contains a copy of that; all others share this one."""
    return int(
        advance_period(drive, phases, angle, speed, link, ratios, legs_mode, alignment, duration, totals)
    )
