"""The compiled closed loop of duty ratios: sense, ask, advance, account, turn the shaft, once a control period."""

from __future__ import annotations

from math import inf, pi
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.loop.exchange import COMPLETED
from drivegate_models.loop.loop_kernel import PLANT_FAULT
from drivegate_models.loop.schedule import Course, Schedule, conditions_at, follow
from drivegate_models.loop.shaft import held_speed, shown_angle, whole_turns, within_a_turn
from drivegate_models.machine import ledger
from drivegate_models.machine.load import LOCKED, Load, load_torque
from drivegate_models.pm_ac.exchange import DutyExchange, ask_controller, take_command, write_sense
from drivegate_models.pm_ac.failure import (
    LOCKED_ROTOR,
    LOST_EDGE,
    LOST_POSITION,
    Failure,
    fail_legs,
    fails_now,
    has_failed,
    show_failed,
)
from drivegate_models.pm_ac.loop_records import DutyRecords, keep_period
from drivegate_models.pm_ac.plant.advance import PmAcPhases, advance_period, stored_energy
from drivegate_models.pm_ac.plant.drive import PmAcDrive, alignment_of, drifted
from drivegate_models.pm_ac.rectifying import settle_rectifying
from drivegate_models.pm_ac.sensing import (
    EXACT,
    DutySensors,
    lose_next_edge,
    low_side_ratio,
    show_phase_currents,
    show_shaft,
    turn_shaft_sensors,
)
from drivegate_models.pm_ac.shaft import speed_change

_LEAST_SHARE: Final = 1e-6
"""Least throughput of a period that counts, over what the link and the current limit exchange in it (1)."""


class DutyTiming(NamedTuple):
    """When things happen in a run."""

    control_period: float
    """(s)."""
    steps: int
    """Control periods."""
    initial_speed: float
    """(rad/s)."""
    initial_angle: float
    """Electrical (rad)."""
    regulates_torque: bool
    """Whether the controller is given a torque reference, not that of the speed."""
    clock_start: float
    """Time that the controller senses in the first step (s)."""


class DutyRoom(NamedTuple):
    """Room for the loop's computations."""

    course_positions: NDArray[np.int64]
    period: NDArray[np.float64]
    ratios: NDArray[np.float64]
    """Duty ratios to act, shape (2, 3): now, and after the delay; zeros before the first answer."""
    legs: NDArray[np.int64]
    """States of the legs likewise, `LEG_OFF` before the first answer."""
    last: NDArray[np.float64]
    """Duty ratios of the period just ended, shape (3,), as `low_side_ratio` returns them."""


@inlined
def _balance(
    resistance: float,
    speed: float,
    growth: float,
    stored: float,
    rated: float,
    period: NDArray[np.float64],
) -> float:
    """Return what energy a period misses over its throughput (1).

    The flux that a period's voltages add up to is rounded, so currents that should be none are some 1e-16 of what
    these voltages can drive, and so is their energy of what the link and the current limit exchange. A throughput
    counts as `_LEAST_SHARE` of that at least: of less, rounding is all there is.
    """
    net = period[ledger.UPPER] + period[ledger.LOWER]
    shaft = speed * period[ledger.IMPULSE]
    missing = net - resistance * period[ledger.SQUARE] - shaft - period[ledger.DEVICE] - growth
    throughput = period[ledger.EXCHANGED] + abs(shaft) + stored
    counted = max(throughput, _LEAST_SHARE * rated)
    if counted == 0.0:
        return 0.0
    share = abs(missing) / counted
    # What is not a number must not pass for a balance.
    return share if share == share else inf


@inlined
def _turn_sensors(sensors: DutySensors, failure: Failure, step: int, length: float, speed: float) -> None:
    """Let what is on the shaft turn for a control period, as far as its edges come."""
    if fails_now(failure, LOST_EDGE, step):
        lose_next_edge(sensors)
    shown = 0.0 if has_failed(failure, LOST_POSITION, step) else speed
    turn_shaft_sensors(sensors, step, step * length, length, shown)


@inlined
def _settle_before_start(
    drive: PmAcDrive, phases: PmAcPhases, load: Load, schedule: Schedule, timing: DutyTiming, room: DutyRoom
) -> int:
    """Bring the machine to its steady state with the legs off, at the speed at which the run begins."""
    begin = conditions_at(schedule, room.course_positions, 0.0)
    speed = begin.speed_reference if load.kind == LOCKED else timing.initial_speed
    return settle_rectifying(
        drifted(drive, begin.resistance_factor, begin.emf_factor),
        phases,
        timing.initial_angle,
        speed,
        2.0 * begin.supply,
        timing.control_period,
        room.ratios[0],
        room.legs[0],
        room.period,
    )


@unallocating
def _run_on(
    drive: PmAcDrive,
    phases: PmAcPhases,
    load: Load,
    schedule: Schedule,
    torque: Course,
    exchange: DutyExchange,
    timing: DutyTiming,
    room: DutyRoom,
    sensors: DutySensors,
    failure: Failure,
    records: DutyRecords,
) -> tuple[int, int]:
    """Run the control periods of a run whose machine is in its first state, as `run_periods` does."""
    length = timing.control_period
    period = room.period
    inertia = drive.inertia + load.inertia
    delay = 1 if drive.modulator.update_delay > 0 else 0
    speed = timing.initial_speed
    angle = timing.initial_angle
    # Whole electrical turns of the shaft's present turn.
    turns = 0
    change = 0.0
    stored = stored_energy(drive, phases)
    observed = records.run
    for k in range(timing.steps):
        observed[0].steps = k
        observed[0].speed_final = speed
        conditions = conditions_at(schedule, room.course_positions, k * length)
        plant = drifted(drive, conditions.resistance_factor, conditions.emf_factor)
        stands = has_failed(failure, LOCKED_ROTOR, k)
        if load.kind == LOCKED or stands:
            speed = 0.0 if stands else conditions.speed_reference
            change = 0.0
        wanted = follow(torque, room.course_positions, 6, k * length)
        reference = wanted if timing.regulates_torque else conditions.speed_reference
        link = 2.0 * conditions.supply
        shaft_angle = shown_angle((angle + 2.0 * pi * turns) / drive.pole_pairs)
        clock = timing.clock_start + k * length
        write_sense(exchange, phases.currents, link, reference, clock, shaft_angle, speed)
        if not sensors.ideal:
            before = alignment_of(drive.modulator.updates, k + 1)
            show_phase_currents(sensors, exchange.sensed_currents, before, room.last, length)
            show_shaft(sensors, exchange.sense[0], k * length)
        is_exact = sensors.ideal or sensors.position == EXACT
        show_failed(failure, k, exchange.sensed_currents, exchange.sense[0], is_exact)
        ask_controller(exchange, k)
        status = take_command(exchange, room.ratios, room.legs, delay)
        if status != COMPLETED:
            return status, k
        fail_legs(failure, k, room.legs[0])
        for entry in range(ledger.ENTRIES):
            period[entry] = 0.0
        held = held_speed(speed, change)
        if advance_period(
            plant,
            phases,
            angle,
            held,
            link,
            room.ratios[0],
            room.legs[0],
            alignment_of(drive.modulator.updates, k),
            length,
            period,
        ):
            return PLANT_FAULT, k
        now = stored_energy(drive, phases)
        rated = link * drive.current_limit * length
        balance = _balance(plant.resistance, held, now - stored, now, rated, period)
        observed[0].worst_balance = max(observed[0].worst_balance, balance)
        stored = now
        ledger.add_period(records.totals, period)
        exchange.sense[0].supply_current = (
            ledger.source_energy(period) / (link * length) if link > 0.0 else 0.0
        )
        opposing = load_torque(load, conditions.load_factor, abs(held))
        begin = (k * length, conditions.speed_reference, speed, angle, link, wanted)
        keep_period(records.trace[k], period, length, phases.rotor_currents, begin, opposing)
        turned = angle + drive.pole_pairs * held * length
        turns = (turns + whole_turns(turned)) % drive.pole_pairs
        angle = within_a_turn(turned)
        if not sensors.ideal:
            _turn_sensors(sensors, failure, k, length, held)
            for leg in range(3):
                room.last[leg] = low_side_ratio(room.ratios[0, leg], room.legs[0, leg])
        if load.kind != LOCKED and not stands:
            change = speed_change(drive, inertia, speed, opposing, period, length)
            speed += change
        if delay > 0:
            for leg in range(3):
                room.ratios[0, leg] = room.ratios[1, leg]
                room.legs[0, leg] = room.legs[1, leg]
    observed[0].steps = timing.steps
    observed[0].speed_final = speed
    return COMPLETED, timing.steps


@unallocating
def run_periods(
    drive: PmAcDrive,
    phases: PmAcPhases,
    load: Load,
    schedule: Schedule,
    torque: Course,
    exchange: DutyExchange,
    timing: DutyTiming,
    room: DutyRoom,
    sensors: DutySensors,
    failure: Failure,
    records: DutyRecords,
) -> tuple[int, int]:
    """Run a controller against the plant.

    Parameters
    ----------
    drive : PmAcDrive
        The drive.
    phases : PmAcPhases
        State of machine, bridge and modulator.
    load : Load
        What the drive turns.
    schedule : Schedule
        What happens; its supply is half of the link's voltage, and its speed the reference.
    torque : Course
        Reference of the torque (N m).
    exchange : DutyExchange
        The controller, and the records shared with it.
    timing : DutyTiming
        Control period and start.
    room : DutyRoom
        Room for computations.
    sensors : DutySensors
        What the controller sees through.
    failure : Failure
        What fails.
    records : DutyRecords
        Filled in.

    Returns
    -------
    status, steps : int
        `COMPLETED` or why the run ended early, and the control periods that were run.

    Notes
    -----
    The legs are off until the first answer acts. The machine begins in the steady state that it has then: without
    current, or with that of the diodes. What leads to this state is no part of the run.
    """
    if _settle_before_start(drive, phases, load, schedule, timing, room):
        return PLANT_FAULT, 0
    return _run_on(drive, phases, load, schedule, torque, exchange, timing, room, sensors, failure, records)
