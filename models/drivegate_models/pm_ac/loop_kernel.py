"""The compiled closed loop of duty ratios: sense, control, advance, record and turn the shaft in each period."""

from __future__ import annotations

from math import inf, nan, pi
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.contract.duty.signals import LEG_OFF, OVERCURRENT, OVERVOLTAGE, TRIP_CURRENT
from drivegate_models.loop.exchange import COMPLETED, STOPPED, Exchange
from drivegate_models.loop.loop_kernel import PLANT_FAULT
from drivegate_models.loop.restarting import Restarts, restart_if_due, waits_again
from drivegate_models.loop.schedule import Course, Schedule, conditions_at, follow
from drivegate_models.loop.shaft import held_speed, motion_of, shown_angle, whole_turns, within_a_turn
from drivegate_models.machine import ledger
from drivegate_models.machine.load import LOCKED, Load, drag_torque, opposing_torque, weight_torque
from drivegate_models.machine.shaft_ledger import account_shaft, stop_shaft
from drivegate_models.pm_ac.exchange import copy_command, step_controller, write_sense
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
from drivegate_models.pm_ac.loop_records import TEMPERATURE, DutyRecords, write_period
from drivegate_models.pm_ac.mean_voltages import MeanVoltages, follow_mean_voltages, show_mean_voltages
from drivegate_models.pm_ac.plant import dc_link
from drivegate_models.pm_ac.plant.advance import PmAcPhases, advance_period, release_legs, stored_energy
from drivegate_models.pm_ac.plant.dc_link import VOLTAGE, LinkState, charge_link, is_ideal, link_energy
from drivegate_models.pm_ac.plant.drive import PmAcDrive, alignment_of, drifted
from drivegate_models.pm_ac.plant.linked_advance import advance_linked_period
from drivegate_models.pm_ac.sensing import (
    EXACT,
    NONE,
    DutySensors,
    drop_signals,
    lose_next_edge,
    low_side_ratio,
    show_currents_of_idle_bridge,
    show_phase_currents,
    show_shaft,
    turn_shaft_sensors,
)
from drivegate_models.pm_ac.turning import Turning, turn_before_run
from drivegate_models.pm_ac.winding import TRUE, Winding, heat_winding, resistance_factor, shown_temperature

NEVER: Final = 2**62
"""Number of a control period that no run has."""
_LEAST_SHARE: Final = 1e-6
"""Minimum throughput of a period in its balance, relative to the energy of link voltage times current limit (1)."""
_LEAST_STORED_SHARE: Final = 1e-4
"""The same for a link, relative to the energy of its capacitor, whose change is a small difference (1)."""


class DutyTiming(NamedTuple):
    """Times and initial values of a run."""

    control_period: float
    """Time between two steps (s)."""
    steps: int
    """Number of control periods."""
    initial_speed: float
    """Speed of the shaft at the start (rad/s)."""
    initial_angle: float
    """Electrical angle at the start (rad)."""
    regulates_torque: bool
    """True if the controller's reference is a torque, False if it is a speed."""
    clock_start: float
    """Time in the controller's first Sense (s)."""
    resting: int = 0
    """Number of control periods at standstill with all legs off, before those of `waiting`."""
    waiting: int = 0
    """Number of control periods with all legs off: before the run, while the shaft turns at its initial speed, and from
    each restart on."""
    released: int = NEVER
    """Control period from which a held shaft turns freely."""
    has_no_start: bool = False
    """True if the plant has no steady state to start from, which ends the run."""


class DutyWorkspace(NamedTuple):
    """Work space of the loop."""

    course_positions: NDArray[np.int64]
    period: NDArray[np.float64]
    ratios: NDArray[np.float64]
    """Duty ratios that act now, and after the delay, shape (2, 3); zeros before the first command."""
    legs: NDArray[np.int64]
    """States of the legs now, and after the delay, shape (2, 3); `LEG_OFF` before the first command."""
    brakes: NDArray[np.float64]
    """Duty ratio of the chopper now, and after the delay, shape (2,); NaN for its own thresholds."""
    last: NDArray[np.float64]
    """Duty ratios of the period just ended, shape (3,), as returned by `low_side_ratio`."""
    no_currents: NDArray[np.float64]
    """Phase currents at standstill with all legs off: zeros, shape (3,) (A)."""


@inlined
def _balance(
    resistance: float,
    speed: float,
    growth: float,
    stored: float,
    rated: float,
    period: NDArray[np.float64],
) -> float:
    """Return the energy that is missing in a period, relative to its throughput (1).

    The flux from a period's voltages is rounded. Currents that should be zero are therefore about 1e-16 of the currents
    that these voltages can drive, and the same applies to their energy. The throughput counts as at least
    `_LEAST_SHARE` of the energy of link voltage times current limit, because smaller ones are only rounding.
    """
    net = period[ledger.UPPER] + period[ledger.LOWER]
    shaft = speed * period[ledger.IMPULSE]
    missing = net - resistance * period[ledger.SQUARE] - shaft - period[ledger.DEVICE] - growth
    throughput = period[ledger.EXCHANGED] + abs(shaft) + stored
    counted = max(throughput, _LEAST_SHARE * rated)
    if counted == 0.0:
        return 0.0
    share = abs(missing) / counted
    # NaN must not count as balanced.
    return share if share == share else inf


@inlined
def _link_balance(drive: PmAcDrive, link: LinkState, stored: float, rated: float, length: float) -> float:
    """Return the energy that is missing in the link in a period, relative to its throughput (1).

    `stored`: energy of capacitor and source at the start (J). `rated`: energy of link voltage times current limit (J).
    The current of the source is rounded like the voltage that drives it.
    """
    totals = link.totals
    constants = drive.dc_link
    now = link_energy(constants, link)
    used = (
        totals[dc_link.RESISTED] + totals[dc_link.BURNT] + totals[dc_link.SUPPLIED] + totals[dc_link.BRIDGE]
    )
    missing = totals[dc_link.DRAWN] - used - (now - stored)
    short = drive.link_voltage * drive.link_voltage / constants.source_resistance * length
    least = _LEAST_SHARE * (rated + short) + _LEAST_STORED_SHARE * (now + stored)
    counted = max(totals[dc_link.THROUGHPUT], least)
    share = abs(missing) / counted
    return share if share == share else inf


@inlined
def _begin_link_ledger(link: LinkState) -> None:
    """Begin the ledger of the link for a control period."""
    for entry in range(dc_link.ENTRIES):
        link.totals[entry] = 0.0
    link.totals[dc_link.HIGHEST] = link.totals[dc_link.LOWEST] = link.state[VOLTAGE]


@inlined
def _sense_link(
    exchange: Exchange, drive: PmAcDrive, link: LinkState, period: NDArray[np.float64], length: float
) -> None:
    """Write what the link shows of the period just ended into the Sense, and what its losses take in the next one."""
    totals = link.totals
    exchange.sense[0].supply_current = totals[dc_link.BRIDGE_CHARGE] / length
    exchange.sense[0].source_current = totals[dc_link.SOURCE_CHARGE] / length
    trip = OVERVOLTAGE if totals[dc_link.HIGHEST] > drive.dc_link.limit else 0
    if period[ledger.PEAK] > TRIP_CURRENT * drive.current_limit:
        trip += OVERCURRENT
    exchange.sense[0].trip = trip
    link.state[dc_link.PENDING] = (period[ledger.CORE_SOURCE] + period[ledger.SWITCHING]) / length


@inlined
def _write_voltages(exchange: Exchange, phases: PmAcPhases, rests: bool, diode_drop: float) -> None:
    """Write the voltages of the terminals at the end of the period just ended into the Sense.

    `rests`: true at standstill before the run, where the dividers pull every terminal down to its lower diode.
    """
    for leg in range(3):
        exchange.sense[0].phase_voltages[leg] = -diode_drop if rests else phases.legs.voltages[leg]


@inlined
def _turn_sensors(
    sensors: DutySensors, failure: Failure, step: int, turning: int, length: float, speed: float
) -> None:
    """Advance the sensor on the shaft by a control period, without edges after a loss of position.

    `step`: number of the period in the run. `turning`: its number since the shaft began to turn.
    """
    if fails_now(failure, LOST_EDGE, step):
        lose_next_edge(sensors)
    shown = 0.0 if has_failed(failure, LOST_POSITION, step) else speed
    turn_shaft_sensors(sensors, turning, turning * length, length, shown)


@inlined
def _turn_off(exchange: Exchange, kept: int, workspace: DutyWorkspace) -> None:
    """Turn all legs off at once, and store that in place of an answer that does not act.

    `kept`: number of the answer among those that are stored.
    """
    for row in range(2):
        for leg in range(3):
            workspace.legs[row, leg] = LEG_OFF
            workspace.ratios[row, leg] = 0.0
        workspace.brakes[row] = nan
    command = exchange.kept[kept]
    command.first_leg = command.second_leg = command.third_leg = LEG_OFF
    command.first_duty = command.second_duty = command.third_duty = 0.0
    command.next_period = 0.0
    command.brake_duty = nan


@inlined
def _command(
    exchange: Exchange,
    restarts: Restarts,
    restarted: int,
    step: int,
    before: int,
    waiting: int,
    workspace: DutyWorkspace,
    delay: int,
) -> tuple[int, int]:
    """Step the controller, after a reset if one is due; return the command's status and the number of resets.

    `step`: number of the control period in the run, negative before it. `before`: number of periods before the run.
    There, and for `waiting` periods from each reset on, the bridge is off whatever the answer is.
    """
    has_failed, restarted = restart_if_due(exchange, restarts, restarted, step)
    if has_failed:
        exchange.kept[before + step] = exchange.command[0]
        return STOPPED, restarted
    waits = waits_again(restarts, restarted, step, waiting)
    exchange.sense[0].enable = 0 if step < 0 or waits else 1
    step_controller(exchange, before + step)
    if waits:
        _turn_off(exchange, before + step, workspace)
    if step < 0 or waits:
        return STOPPED if exchange.command[0].struct_size < 0 else COMPLETED, restarted
    return copy_command(exchange, workspace.ratios, workspace.legs, workspace.brakes, delay), restarted


@unallocating
def release_before_start(
    drive: PmAcDrive,
    phases: PmAcPhases,
    load: Load,
    schedule: Schedule,
    timing: DutyTiming,
    workspace: DutyWorkspace,
    winding: Winding,
) -> tuple[float, float, tuple[float, float]]:
    """Turn all legs off at the initial speed of the run, as they are until a command acts.

    Returns that speed (rad/s), the link voltage (V) and the factors on winding resistance and magnet flux (1).
    A kernel of its own passes through the compiler in half the time.
    """
    begin = conditions_at(schedule, workspace.course_positions, 0.0)
    speed = begin.speed if load.kind == LOCKED else timing.initial_speed
    link = 2.0 * begin.supply
    resistance = begin.resistance * resistance_factor(winding)
    plant = drifted(drive, resistance, begin.emf_constant)
    if not is_ideal(drive.dc_link):
        charge_link(phases.dc_link, link)
    release_legs(plant, phases, timing.initial_angle, speed, link)
    return speed, link, (resistance, begin.emf_constant)


@unallocating
def run_periods(
    drive: PmAcDrive,
    phases: PmAcPhases,
    load: Load,
    schedule: Schedule,
    torque: Course,
    exchange: Exchange,
    timing: DutyTiming,
    workspace: DutyWorkspace,
    sensors: DutySensors,
    failure: Failure,
    restarts: Restarts,
    turning: Turning,
    winding: Winding,
    voltages: MeanVoltages,
    records: DutyRecords,
) -> tuple[int, int]:
    """Run a controller against the plant, whose machine is in its initial state.

    `schedule`: external conditions. The supply is half of the link voltage, and the speed is the reference. `torque`:
    torque reference (N m). `turning`: turns of the shaft before the run. `winding`: thermal node. `voltages`: sensor
    of means.
    Control periods before the run have negative numbers and are not recorded. Returns `status`, `steps`: `COMPLETED` or
    the reason for an early end, and the number of completed control periods, including those before the run.
    """
    if timing.has_no_start:
        return PLANT_FAULT, 0
    length = timing.control_period
    period = workspace.period
    delay = 1 if drive.modulator.update_delay > 0 else 0
    speed = timing.initial_speed
    angle = timing.initial_angle
    # Whole electrical turns of the shaft's present turn.
    turns = 0
    change = 0.0
    restarted = 0
    stored = stored_energy(drive, phases)
    has_ideal_link = is_ideal(drive.dc_link)
    observed = records.run
    before = timing.resting + timing.waiting
    for k in range(-before, timing.steps):
        observed[0].steps = before + k
        observed[0].speed_final = speed
        rests = k < -timing.waiting
        now = max(k, 0) * length
        # The sensors' own time begins when the shaft turns.
        since_turning = max(k + timing.waiting, 0)
        conditions = conditions_at(schedule, workspace.course_positions, now)
        plant = drifted(drive, conditions.resistance * resistance_factor(winding), conditions.emf_constant)
        is_locked = has_failed(failure, LOCKED_ROTOR, k)
        is_held = load.kind == LOCKED and k < timing.released
        if is_held or is_locked:
            speed = 0.0 if is_locked else conditions.speed
            change = 0.0
            if is_locked:
                stop_shaft(records.shaft)
        torque_reference = follow(torque, workspace.course_positions, len(schedule), now)
        reference = torque_reference if timing.regulates_torque else conditions.speed
        source = 2.0 * conditions.supply
        link = source if has_ideal_link else phases.dc_link.state[VOLTAGE]
        shaft_angle = shown_angle((angle + 2.0 * pi * turns) / drive.pole_pairs)
        exchange.sense[0].winding_temperature = shown_temperature(winding)
        if turning.periods > 0 and k == -timing.waiting:
            begin_turning = (angle, timing.clock_start + (before + k) * length)
            idle = 0.0 if timing.regulates_torque else turning.speed
            enable = 0 if timing.waiting > 0 else 1
            if (
                turn_before_run(
                    drive, exchange, turning, begin_turning, link, idle, length, enable, voltages.is_sensed
                )
                != COMPLETED
            ):
                exchange.kept[before + k] = exchange.command[0]
                return STOPPED, before + k
        turned_before = turning.periods if k >= -timing.waiting else 0
        clock = timing.clock_start + (turned_before + before + k) * length
        currents = workspace.no_currents if rests else phases.currents
        write_sense(exchange, currents, link, reference, clock, shaft_angle, speed)
        _write_voltages(exchange, phases, rests, drive.diode_drop)
        show_mean_voltages(voltages, exchange)
        if not sensors.ideal:
            if k < 0 or waits_again(restarts, restarted, k - 1, timing.waiting):
                show_currents_of_idle_bridge(sensors, exchange.sensed_currents)
            else:
                ended = alignment_of(drive.modulator.updates, k + 1)
                carrier = length / drive.modulator.control_every
                show_phase_currents(sensors, exchange.sensed_currents, ended, workspace.last, carrier)
            show_shaft(sensors, exchange.sense[0], since_turning, length)
        is_exact = sensors.ideal or sensors.position == EXACT
        show_failed(failure, k, exchange.sensed_currents, exchange.sense[0], is_exact)
        drop_signals(sensors, k * length, exchange.sensed_currents, exchange.sense[0])
        if rests and sensors.position != NONE:
            exchange.sense[0].speed = 0.0
        status, restarted = _command(
            exchange, restarts, restarted, k, before, timing.waiting, workspace, delay
        )
        if status != COMPLETED:
            return status, before + k
        if rests:
            continue
        fail_legs(failure, k, workspace.legs[0])
        for entry in range(ledger.ENTRIES):
            period[entry] = 0.0
        held = held_speed(speed, change)
        carrier = length / drive.modulator.control_every
        charged = 0.0
        if not has_ideal_link:
            charged = link_energy(drive.dc_link, phases.dc_link)
            _begin_link_ledger(phases.dc_link)
        for part in range(drive.modulator.control_every):
            begin_angle = angle + part * (drive.pole_pairs * held * carrier)
            if not has_ideal_link:
                if advance_linked_period(
                    plant,
                    phases,
                    begin_angle,
                    held,
                    source,
                    workspace.ratios[0],
                    workspace.legs[0],
                    workspace.brakes[0],
                    alignment_of(drive.modulator.updates, k),
                    carrier,
                    period,
                ):
                    return PLANT_FAULT, before + k
                continue
            if advance_period(
                plant,
                phases,
                begin_angle,
                held,
                link,
                workspace.ratios[0],
                workspace.legs[0],
                alignment_of(drive.modulator.updates, k),
                carrier,
                period,
            ):
                return PLANT_FAULT, before + k
        follow_mean_voltages(voltages, phases.volt_seconds, length)
        stored_now = stored_energy(drive, phases)
        rated = link * drive.current_limit * length
        balance = _balance(plant.resistance, held, stored_now - stored, stored_now, rated, period)
        observed[0].worst_balance = max(observed[0].worst_balance, balance)
        stored = stored_now
        exchange.sense[0].supply_current = (
            ledger.source_energy(period) / (link * length) if link > 0.0 else 0.0
        )
        exchange.sense[0].source_current = exchange.sense[0].supply_current
        seen_link = link, link, exchange.sense[0].supply_current, 0.0
        if not has_ideal_link:
            balance = _link_balance(drive, phases.dc_link, charged, rated, length)
            observed[0].worst_balance = max(observed[0].worst_balance, balance)
            _sense_link(exchange, drive, phases.dc_link, period, length)
            account = phases.dc_link.totals
            seen_link = (
                account[dc_link.FLUX] / length,
                account[dc_link.HIGHEST],
                account[dc_link.SOURCE_CHARGE] / length,
                account[dc_link.BURNT] / length,
            )
        opposing = opposing_torque(load, conditions.load, abs(held))
        weight = weight_torque(load, conditions.load)
        if k >= 0:
            records.trace[k, TEMPERATURE] = winding.state[TRUE]
            heat_winding(winding, plant.resistance * period[ledger.SQUARE] / length)
            ledger.add_period(records.totals, period)
            begin = (now, conditions.speed, speed, angle, link, torque_reference)
            load_now = weight + (opposing if held >= 0.0 else -opposing)
            write_period(records.trace[k], period, length, phases.rotor_currents, begin, load_now, seen_link)
        turned = angle + drive.pole_pairs * held * length
        turns = (turns + whole_turns(turned)) % drive.pole_pairs
        angle = within_a_turn(turned)
        if not sensors.ideal:
            _turn_sensors(sensors, failure, k, since_turning, length, held)
            for leg in range(3):
                workspace.last[leg] = low_side_ratio(workspace.ratios[0, leg], workspace.legs[0, leg])
        if k >= 0 and not is_held and not is_locked:
            inertia = conditions.inertia * (drive.inertia + load.inertia)
            resisting = (opposing, drag_torque(load, held), conditions.friction)
            gained, change = _turn(
                drive, load, conditions.load, inertia, speed, resisting, weight, period, length, records.shaft
            )
            speed += gained
        if delay > 0:
            for leg in range(3):
                workspace.ratios[0, leg] = workspace.ratios[1, leg]
                workspace.legs[0, leg] = workspace.legs[1, leg]
            workspace.brakes[0] = workspace.brakes[1]
    observed[0].steps = before + timing.steps
    observed[0].speed_final = speed
    return COMPLETED, before + timing.steps


@inlined
def _turn(
    drive: PmAcDrive,
    load: Load,
    factor: float,
    inertia: float,
    speed: float,
    resisting: tuple[float, float, float],
    weight: float,
    period: NDArray[np.float64],
    length: float,
    account: NDArray[np.float64],
) -> tuple[float, float]:
    """Turn the shaft in a control period, and add the period to the shaft's ledger.

    - `load`, `factor`: load, and the factor on its size, or a vehicle's grade (1).
    - `inertia`: inertia of rotor and load (kg m2).
    - `speed`: speed at the start of the period (rad/s).
    - `resisting`: torque of the load that opposes the rotation, the part of it that is a vehicle's drag, and torque
      added to the friction (N m).
    - `weight`: torque that turns the shaft backward, whichever way it turns (N m).
    - `period`, shape (ledger.ENTRIES,): exact integrals over the period.
    - `length`: length of the period (s).
    - `account`, shape (shaft_ledger.ENTRIES,): the shaft's ledger, updated.
    - Result: change of speed, and change in a whole period at the last acceleration (rad/s).
    """
    machine = (period[ledger.IMPULSE] - period[ledger.CORE_DRAG_IMPULSE]) / length
    opposing, drag, added = resisting
    motion = motion_of(
        machine - weight, (opposing + added) + drive.friction, drive.viscous_friction, inertia, speed, length
    )
    account_shaft(
        account,
        load,
        factor,
        inertia,
        (speed, motion.gained, motion.share),
        length,
        machine,
        opposing,
        drag,
        added + drive.friction,
        drive.viscous_friction,
    )
    return motion.gained, motion.trend
