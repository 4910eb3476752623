"""The closed loop of a PM AC drive with a controller that answers with duty ratios, called by address."""

from __future__ import annotations

from math import pi
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.calling import call_step
from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.contract.duty.records import DUTY_COMMAND, duty_command_record, duty_sense_record
from drivegate_models.loop.duty_command import duty_command_status
from drivegate_models.loop.exchange import COMPLETED
from drivegate_models.loop.loop_kernel import PLANT_FAULT
from drivegate_models.loop.schedule import Conditions, Course, Schedule, conditions_at, follow, steady
from drivegate_models.loop.shaft import held_speed, within_a_turn
from drivegate_models.machine import ledger
from drivegate_models.machine.load import LOCKED, Load, load_torque
from drivegate_models.pm_ac.failure import (
    LOCKED_ROTOR,
    LOST_POSITION,
    Failure,
    fail_legs,
    has_failed,
    make_failure,
    show_failed,
)
from drivegate_models.pm_ac.plant.advance import PmAcPhases, advance_period, make_phases, stored_energy
from drivegate_models.pm_ac.plant.drive import CENTRED, FALLING, RISING, PmAcDrive, drifted
from drivegate_models.pm_ac.sensing import (
    EXACT,
    DutySensors,
    ideal_duty_sensors,
    low_side_ratio,
    show_phase_currents,
    show_shaft,
    turn_shaft_sensors,
)

TRACE: Final = (
    "time",
    "speed_reference",
    "speed",
    "torque",
    "direct",
    "quadrature",
    "peak_current",
    "input_power",
    "load",
    "angle",
    "link",
    "torque_reference",
)
"""Columns of a run's trace: means over a control period, currents of the rotor frame at its end, greatest current.

Speed, electrical angle, link voltage and references are those of its start.
"""


class DutyExchange(NamedTuple):
    """The records through which loop and controller talk, and where the controller is."""

    sense: NDArray[Any]
    """Shape (1,) of DUTY_SENSE."""
    command: NDArray[Any]
    """Shape (1,) of DUTY_COMMAND."""
    fresh: NDArray[Any]
    """What a command is before the step, shape (1,) of DUTY_COMMAND."""
    kept: NDArray[Any]
    """Receives the command of each step, shape (steps,) of DUTY_COMMAND or more."""
    progress: NDArray[np.int64]
    """Shape (1,): number of steps begun, watched from another process."""
    sensed_currents: NDArray[np.float64]
    """Shape (3,) (A)."""
    step_address: int
    """Address of the controller's step."""
    state_address: int
    """Address of its state."""
    sense_address: int
    """Address of `sense`."""
    command_address: int
    """Address of `command`."""


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


class DutyRoom(NamedTuple):
    """Room for the loop's computations."""

    course_positions: NDArray[np.int64]
    period: NDArray[np.float64]
    ratios: NDArray[np.float64]
    """Duty ratios to act, shape (2, 3): now, and after the delay."""
    legs: NDArray[np.int64]
    """States of the legs likewise."""
    last: NDArray[np.float64]
    """Duty ratios of the period just ended, shape (3,)."""


_LEAST_SHARE: Final = 1e-6
"""Least throughput of a period that counts, over what the link and the current limit exchange in it (1)."""
RUN_RECORD: Final = np.dtype(
    [("steps", np.int64), ("speed_final", np.float64), ("worst_balance", np.float64)], align=True
)
"""Control periods that were run, speed of the shaft behind them (rad/s), and the worst balance of energy (1)."""


class DutyRecords(NamedTuple):
    """What a run fills in."""

    run: NDArray[Any]
    """Shape (1,) of RUN_RECORD."""
    trace: NDArray[np.float64]
    """Shape (steps, len(TRACE))."""
    totals: NDArray[np.float64]
    """Exact integrals over the run, shape (ledger.ENTRIES,)."""


class DutyRun(NamedTuple):
    """What came of a run."""

    status: int
    """`COMPLETED`, or another status of `loop.exchange`, `loop_kernel.PLANT_FAULT` or `duty_command.BAD_LEG`."""
    steps: int
    """Control periods that were run."""
    trace: NDArray[np.float64]
    """Shape (steps, len(TRACE))."""
    totals: NDArray[np.float64]
    """Exact integrals over the run, shape (ledger.ENTRIES,)."""
    worst_balance: float
    """Greatest energy that a period misses, over its throughput (1)."""
    commands: NDArray[Any]
    """The command of each step that was asked for, shape (n,) of DUTY_COMMAND."""


@inlined
def _take_command(command: Any, room: DutyRoom, place: int) -> int:
    """Take over a command; return `COMPLETED` or why it is none."""
    status = duty_command_status(command)
    room.legs[place, 0] = command.first_leg
    room.legs[place, 1] = command.second_leg
    room.legs[place, 2] = command.third_leg
    room.ratios[place, 0] = command.first_duty
    room.ratios[place, 1] = command.second_duty
    room.ratios[place, 2] = command.third_duty
    return status


@inlined
def alignment_of(updates: int, step: int) -> int:
    """Return where in a control period the upper switch is on."""
    if updates == 0:
        return FALLING
    if updates == 1:
        return CENTRED
    return RISING if step % 2 == 0 else FALLING


@inlined
def _speed_change(
    drive: PmAcDrive, inertia: float, speed: float, load: float, period: NDArray[np.float64], length: float
) -> float:
    """Return by how much the shaft's speed changes in a control period (rad/s)."""
    driving = (period[ledger.IMPULSE] - period[ledger.CORE_DRAG_IMPULSE]) / length
    driving -= drive.viscous_friction * speed
    opposing = load + drive.friction
    # Load and friction oppose a shaft that turns and hold one that stands; they never turn it.
    forward = float((driving - opposing) * length / inertia)
    backward = float((driving + opposing) * length / inertia)
    if speed > 0.0:
        return max(forward, -speed) if driving >= -opposing else forward
    if speed < 0.0:
        return min(backward, -speed) if driving <= opposing else backward
    return max(forward, 0.0) + min(backward, 0.0)


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
    return abs(missing) / counted if counted > 0.0 else 0.0


@inlined
def _write_sense(
    exchange: DutyExchange,
    phases: PmAcPhases,
    conditions: Conditions,
    reference: float,
    time: float,
    angle: float,
    speed: float,
) -> None:
    """Write what is sensed at the start of a period."""
    sense = exchange.sense
    sense[0].time = time
    sense[0].reference = reference
    sense[0].supply_voltage = 2.0 * conditions.supply
    sense[0].angle = angle
    sense[0].speed = speed
    for leg in range(3):
        exchange.sensed_currents[leg] = phases.currents[leg]


@unallocating
def _run(
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
    """Run a closed loop; return status and steps."""
    length = timing.control_period
    period = room.period
    inertia = drive.inertia + load.inertia
    delay = 1 if drive.modulator.update_delay > 0 else 0
    speed = timing.initial_speed
    angle = timing.initial_angle
    change = 0.0
    stored = stored_energy(drive, phases)
    trace, totals, observed = records.trace, records.totals, records.run
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
        _write_sense(exchange, phases, conditions, reference, k * length, angle / drive.pole_pairs, speed)
        if not sensors.ideal:
            before = alignment_of(drive.modulator.updates, k + 1)
            show_phase_currents(sensors, exchange.sensed_currents, before, room.last, length)
            show_shaft(sensors, exchange.sense[0], drive.pole_pairs)
        show_failed(
            failure,
            k,
            exchange.sensed_currents,
            exchange.sense[0],
            sensors.ideal or sensors.position == EXACT,
        )
        exchange.command[0] = exchange.fresh[0]
        # Counted before the call, so that whoever watches knows in which step a controller hangs.
        exchange.progress[0] = k + 1
        call_step(
            exchange.step_address, exchange.state_address, exchange.sense_address, exchange.command_address
        )
        exchange.kept[k] = exchange.command[0]
        status = _take_command(exchange.command[0], room, delay)
        if status != COMPLETED:
            return status, k
        fail_legs(failure, k, room.legs[0])
        for entry in range(ledger.ENTRIES):
            period[entry] = 0.0
        link = 2.0 * conditions.supply
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
        ledger.add_period(totals, period)
        exchange.sense[0].supply_current = (
            ledger.source_energy(period) / (link * length) if link > 0.0 else 0.0
        )
        opposing = load_torque(load, conditions.load_factor, abs(held))
        row = trace[k]
        row[0] = k * length
        row[1] = conditions.speed_reference
        row[2] = speed
        row[3] = period[ledger.IMPULSE] / length
        row[4] = phases.rotor_currents[0]
        row[5] = phases.rotor_currents[1]
        row[6] = period[ledger.PEAK]
        row[7] = ledger.source_energy(period) / length
        row[8] = opposing
        row[9] = angle
        row[10] = link
        row[11] = wanted
        angle = within_a_turn(angle + drive.pole_pairs * held * length)
        if not sensors.ideal:
            shown = 0.0 if has_failed(failure, LOST_POSITION, k) else held
            turn_shaft_sensors(sensors, k, k * length, length, shown)
            for leg in range(3):
                room.last[leg] = low_side_ratio(room.ratios[0, leg], room.legs[0, leg])
        if load.kind != LOCKED and not stands:
            change = _speed_change(drive, inertia, speed, opposing, period, length)
            speed += change
        if delay > 0:
            for leg in range(3):
                room.ratios[0, leg] = room.ratios[1, leg]
                room.legs[0, leg] = room.legs[1, leg]
    observed[0].steps = timing.steps
    observed[0].speed_final = speed
    return COMPLETED, timing.steps


class PreparedDutyLoop(NamedTuple):
    """A run that is ready to begin."""

    loop: Any
    """The compiled loop."""
    arguments: tuple[Any, ...]
    """What it is called with."""
    exchange: DutyExchange
    """The records between loop and controller."""
    records: DutyRecords
    """What the run fills in."""

    def run(self) -> DutyRun:
        """Run the controller, already reset, to the end or to where it stops."""
        status, done = self.loop(*self.arguments)
        records = self.records
        asked = self.exchange.kept[: done + (status != COMPLETED)]
        worst = float(records.run["worst_balance"][0])
        return DutyRun(int(status), int(done), records.trace[:done], records.totals, worst, asked)


def prepared_duty_loop(
    drive: PmAcDrive,
    load: Load,
    schedule: Schedule,
    *,
    step_address: int,
    state_address: int,
    control_period: float,
    duration: float,
    initial_speed: float = 0.0,
    initial_angle: float = 0.0,
    torque_reference: Course | None = None,
    sensors: DutySensors | None = None,
    failure: Failure | None = None,
    progress: NDArray[np.int64] | None = None,
    kept: NDArray[Any] | None = None,
) -> PreparedDutyLoop:
    """Make a run of a controller against the plant ready to begin.

    Parameters
    ----------
    drive : PmAcDrive
        The drive.
    load : Load
        What it drives.
    schedule : Schedule
        What happens; its supply is half of the link's voltage, and its speed the reference.
    step_address, state_address : int
        Addresses of the controller's step function and of its state.
    control_period : float
        (s).
    duration : float
        (s).
    initial_speed : float
        Of the shaft (rad/s).
    initial_angle : float
        Electrical, from the first phase's axis to the magnet's (rad).
    torque_reference : Course, optional
        What the controller is given in place of the schedule's speed (N m).
    sensors : DutySensors, optional
        What the controller sees through; the plant as it is where they are left out.
    failure : Failure, optional
        What fails.
    progress : ndarray of int64, shape (1,), optional
        Receives the number of steps begun.
    kept : ndarray of DUTY_COMMAND, shape (n,), optional
        Receives the commands, with room for those of all steps.

    Returns
    -------
    PreparedDutyLoop
        The run. Before the first answer acts, the duty ratios are all 1/2.
    """
    steps = round(duration / control_period)
    currents = np.zeros(3)
    sense, command, fresh = duty_sense_record(currents), duty_command_record(), duty_command_record()
    exchange = DutyExchange(
        sense,
        command,
        fresh,
        np.zeros(steps, DUTY_COMMAND) if kept is None else kept,
        np.zeros(1, np.int64) if progress is None else progress,
        currents,
        step_address,
        state_address,
        sense.ctypes.data,
        command.ctypes.data,
    )
    records = DutyRecords(np.zeros(1, RUN_RECORD), np.zeros((steps, len(TRACE))), np.zeros(ledger.ENTRIES))
    room = DutyRoom(
        np.zeros(7, np.int64),
        np.zeros(ledger.ENTRIES),
        np.full((2, 3), 0.5),
        np.ones((2, 3), np.int64),
        np.full(3, 0.5),
    )
    timing = DutyTiming(
        float(control_period),
        steps,
        float(initial_speed),
        float(initial_angle % (2.0 * pi)),
        torque_reference is not None,
    )
    torque = steady(0.0) if torque_reference is None else torque_reference
    shown = ideal_duty_sensors() if sensors is None else sensors
    fails = make_failure() if failure is None else failure
    arguments = (drive, make_phases(), load, schedule, torque, exchange, timing, room, shown, fails, records)
    return PreparedDutyLoop(_run, arguments, exchange, records)


def run_duty_loop(drive: PmAcDrive, load: Load, schedule: Schedule, **options: Any) -> DutyRun:
    """Run a controller that has been reset against the plant.

    Parameters
    ----------
    drive : PmAcDrive
        The drive.
    load : Load
        What it drives.
    schedule : Schedule
        What happens.
    **options
        As `prepared_duty_loop` has them.

    Returns
    -------
    DutyRun
        Its trace, totals and commands.
    """
    return prepared_duty_loop(drive, load, schedule, **options).run()
