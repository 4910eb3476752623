"""The closed loop: its account of energy, its loads, its convergence with the control period, and its limits."""

import math
import tracemalloc
from typing import Any

import numpy as np
import pytest
from tests.models.schedules import schedule_of

from drivegate_models.contract.current.records import COMMAND, nameplate_record
from drivegate_models.contract.current.signals import Nameplate
from drivegate_models.controllers.current.builtin import SEARCHES, reset_function, step_function
from drivegate_models.controllers.current.state import CONTROLLER_STATE
from drivegate_models.half_bridge.closed_loop import prepared_loop
from drivegate_models.loop import exchange, observation
from drivegate_models.loop.closed_loop import ClosedLoopRun
from drivegate_models.loop.loop_inputs import CurrentLoopInputs, SteppedController
from drivegate_models.loop.schedule import Course, Schedule
from drivegate_models.loop.step_recording import player_of, playing_step
from drivegate_models.machine import ledger, shaft_ledger
from drivegate_models.machine.load import (
    CONSTANT_POWER,
    CONSTANT_TORQUE,
    LOCKED,
    VEHICLE,
    Load,
)

RPM = math.pi / 30.0


def course(*points: tuple[float, float]) -> Course:
    table = np.array(points, float)
    return Course(np.ascontiguousarray(table[:, 0]), np.ascontiguousarray(table[:, 1]))


def schedule(speed: float, factor: tuple[tuple[float, float], ...]) -> Schedule:
    return schedule_of(speed, 48.0, load=course(*factor))


def simulate(
    drive: Any,
    load: Load,
    *,
    name: str = "reference",
    speed: float = 1500.0 * RPM,
    duration: float = 2.0,
    period: float = 5e-4,
    factor: tuple[tuple[float, float], ...] = ((0.0, 0.0), (0.2, 1.0)),
    trace_every: int = 0,
    initial_speed: float | None = None,
    mean_time: float = 0.1,
) -> ClosedLoopRun:
    state = np.zeros(1, CONTROLLER_STATE)
    nameplate = Nameplate(
        drive.phases,
        drive.pole_pairs,
        48.0,
        500.0 * RPM,
        1500.0,
        drive.current_limit,
        period,
        drive.hysteresis_band,
        drive.resistance,
        drive.inductance,
        drive.emf_constant,
        drive.inertia,
        1,
        drive.window,
        drive.phases * drive.window / np.pi,
        np.radians(33.0),
        np.radians(0.025) / RPM,
        1500.0 * RPM,
    )
    reset_function()(state, nameplate_record(nameplate), SEARCHES[name])
    return prepared_loop(
        CurrentLoopInputs(
            drive=drive,
            load=load,
            schedule=schedule(speed, factor),
            initial_speed=speed if initial_speed is None else initial_speed,
            base_speed=500.0 * RPM,
            control_period=period,
            duration=duration,
            windows=[(0.5 * duration, duration)],
            trace_every=trace_every,
            mean_time=mean_time,
        ),
        SteppedController(step_function().address, state.ctypes.data),
    ).run()


def test_a_mean_over_more_periods_of_a_current_sum_that_stands_still_varies_less(motor: Any) -> None:
    load = Load(CONSTANT_TORQUE, 8.0, 1.0)
    spreads = [
        window.current_sum_range
        for mean_time in (0.0015, 0.1)
        for window in simulate(motor(), load, name="initial", mean_time=mean_time).windows
    ]
    assert spreads[1] < 0.1 * spreads[0], f"Σ|i| varies by {spreads} A"


def test_a_window_has_the_means_that_its_trace_has(motor: Any) -> None:
    run = simulate(motor(), Load(CONSTANT_TORQUE, 8.0, 1.0), name="reference", trace_every=1)
    # The window is the second half, 2000 periods; 200 of them are a mean.
    rows = run.trace[len(run.trace) // 2 :]
    (window,) = run.windows
    for place, (column, power) in enumerate(
        (("current_sum_a", 1.0), ("current_reference_a", 2.0), ("advance_deg", 1.0))
    ):
        unit = math.radians(1.0) if column == "advance_deg" else 1.0
        means = ((unit * rows[column]) ** power).reshape(-1, 200).mean(axis=1) ** (1.0 / power)
        assert window.means[:, place] == pytest.approx(means, rel=1e-12), column
        assert means.max() > means.min(), f"{column} does not move, so that nothing is tested"


@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_the_energy_of_a_whole_run_is_accounted_for(motor: Any, friction: float) -> None:
    drive = motor(friction=friction, viscous_friction=1e-3, core_loss_conductance=3e-3, inertia=0.05)
    run = simulate(drive, Load(CONSTANT_TORQUE, 8.0, 1.0))
    totals = run.totals
    assert run.status == exchange.COMPLETED
    assert run.observed.exchange_error < 1e-12, "a control period does not close"
    source = (
        totals[ledger.UPPER] + totals[ledger.LOWER] + totals[ledger.CORE_SOURCE] + totals[ledger.SWITCHING]
    )
    assert run.observed.input_energy == pytest.approx(source, rel=1e-12)
    assert shaft_ledger.shaft_error(run.shaft) < 1e-12
    works = {name: run.shaft[getattr(shaft_ledger, name)] for name in shaft_ledger.OPPOSING}
    assert works["BRAKE"] > 0.0
    assert works["FRICTION"] > 0.0
    speed = 1500.0 * RPM
    assert run.shaft[shaft_ledger.BEGIN] == pytest.approx(0.5 * 0.05 * speed**2, rel=1e-12)
    spent = (
        drive.resistance * totals[ledger.SQUARE]
        + run.observed.shaft_energy
        + totals[ledger.CORE_SOURCE]
        + totals[ledger.DEVICE]
    )
    # What is left in the windings at the end is below half L times the square of the peak in each phase.
    left = 0.5 * drive.inductance * drive.phases * totals[ledger.PEAK] ** 2
    assert 0.0 <= source - spent <= left, f"{source - spent} J are missing"


def test_holding_the_speed_within_a_period_vanishes_with_the_period(motor: Any) -> None:
    drive = motor(inertia=0.05, core_loss_conductance=3e-3)
    residuals, speeds = [], []
    for period in (1e-4, 5e-5, 2.5e-5):
        run = simulate(drive, Load(CONSTANT_TORQUE, 9.8, 1.0), name="initial", period=period, duration=1.0)
        residuals.append(run.observed.kinetic_residual)
        speeds.append(run.observed.speed_final)
    assert residuals[0] > 1.5 * residuals[1] > 2.0 * residuals[2], (
        f"the residual does not vanish: {residuals}"
    )
    assert abs(speeds[2] - speeds[1]) < 0.02, f"the speeds do not converge: {speeds}"


def given_commands(drive: Any, period: float, current: float, advance: float) -> ClosedLoopRun:
    """Run up under a constant torque with a current and an angle that do not change."""
    steps = round(0.3 / period)
    commands = np.array([(0, current, advance, math.nan)] * steps, COMMAND)
    state = player_of(commands)
    return prepared_loop(
        CurrentLoopInputs(
            drive=drive,
            load=Load(CONSTANT_TORQUE, 3.0, 0.0),
            schedule=schedule(500.0 * RPM, ((0.0, 1.0),)),
            initial_speed=600.0 * RPM,
            base_speed=500.0 * RPM,
            control_period=period,
            duration=steps * period,
            windows=[],
        ),
        SteppedController(playing_step().address, state.ctypes.data),
    ).run()


def test_the_speed_of_a_run_up_hardly_depends_on_the_period_that_holds_it(motor: Any) -> None:
    drive = motor(inertia=0.05, hysteresis_band=0.0)
    speeds = [
        given_commands(drive, period, 20.0, math.radians(20.0)).observed.speed_final / RPM
        for period in (1e-3, 5e-4, 1.25e-4, 1.5625e-5)
    ]
    # Held at the speed of a period's start, the first three would be 0.63, 0.32 and 0.08 rpm too high.
    assert max(abs(speed - speeds[-1]) for speed in speeds) < 0.005, f"run-ups end at {speeds} rpm"
    assert speeds[-1] > 1100.0, "the drive has hardly run up, which shows nothing"


def test_mean_torque_carries_load_friction_and_core_drag(motor: Any) -> None:
    drive = motor(friction=0.3, viscous_friction=2e-3, core_loss_conductance=3e-3, inertia=0.05)
    run = simulate(drive, Load(CONSTANT_POWER, 1000.0, 1.0), name="initial", duration=4.0)
    window = run.windows[0]
    speed = window.speed
    resisting = 1000.0 / speed + 0.3 + 2e-3 * speed
    drag = window.torque - resisting
    assert 0.0 < drag < 0.05, f"{drag} N·m are not load or friction, more than the core can drag"


def test_a_dynamometer_holds_the_speed(motor: Any) -> None:
    run = simulate(motor(), Load(LOCKED, 0.0, 1.0), speed=900.0 * RPM, factor=((0.0, 1.0),))
    assert run.observed.speed_final == 900.0 * RPM


def test_load_and_friction_never_drive_the_shaft_backward(motor: Any) -> None:
    drive = motor(friction=1.0, inertia=0.05)
    run = simulate(
        drive, Load(CONSTANT_TORQUE, 500.0, 1.0), speed=100.0 * RPM, factor=((0.0, 1.0),), trace_every=1
    )
    assert run.trace["speed_rpm"].min() == 0.0, f"the shaft turns at {run.trace['speed_rpm'].min()} rpm"


@pytest.mark.parametrize("grade", [-0.05, 0.05])
def test_a_vehicle_is_pulled_down_its_slope_and_never_rolls_backward(motor: Any, grade: float) -> None:
    """Uphill a one-way clutch holds it; downhill it accelerates as its weight less the rolling resistance says."""
    drive = motor(inertia=0.05)
    weight, rolling, inertia = 8.0, 0.01, 0.15
    run = simulate(
        drive,
        Load(VEHICLE, weight, rolling=rolling, inertia=inertia),
        speed=0.0,
        factor=((0.0, grade),),
        duration=1.0,
    )
    slope = weight / math.hypot(1.0, grade)
    expected = max(-slope * (grade + rolling), 0.0) / (drive.inertia + inertia)
    assert run.observed.speed_final == pytest.approx(expected, rel=1e-9)
    taken = 0.5 * (drive.inertia + inertia) * expected**2
    assert -run.shaft[shaft_ledger.GRADE] == pytest.approx(taken + run.shaft[shaft_ledger.ROLLING], rel=1e-9)
    assert shaft_ledger.shaft_error(run.shaft) < 1e-12


def test_the_same_run_twice_is_the_same_bit_for_bit(motor: Any) -> None:
    first = simulate(motor(inertia=0.05), Load(CONSTANT_TORQUE, 9.0, 1.0))
    second = simulate(motor(inertia=0.05), Load(CONSTANT_TORQUE, 9.0, 1.0))
    other = simulate(motor(inertia=0.05), Load(CONSTANT_TORQUE, 9.0 + 1e-9, 1.0))
    assert first.digest == second.digest
    assert first.totals.tobytes() == second.totals.tobytes()
    assert other.digest != first.digest, "the digest does not see a difference of 1e-9 N·m"


def test_memory_grows_by_the_means_of_a_run_alone(motor: Any) -> None:
    peaks = []
    for duration in (1.0, 1.0, 30.0):
        tracemalloc.start()
        simulate(motor(inertia=0.05), Load(CONSTANT_TORQUE, 5.0, 1.0), duration=duration)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    # Three numbers for each 100 ms of the window, which is half of the run.
    means = 3 * 8 * round(0.5 * 29.0 / observation.MEAN_TIME)
    assert peaks[2] <= peaks[1] + means + 4096, f"{peaks[1]} bytes for 1 s, but {peaks[2]} bytes for 30 s"


def test_the_trace_keeps_every_nth_period(motor: Any) -> None:
    run = simulate(motor(inertia=0.05), Load(CONSTANT_TORQUE, 5.0, 1.0), duration=0.5, trace_every=7)
    assert run.trace.shape == (math.ceil(1000 / 7),)
    assert np.allclose(np.diff(run.trace["time_s"]), 7 * 5e-4)


@pytest.mark.parametrize("steps", [1, 2, 64, 128, 192])
def test_constant_commands_that_differ_are_distinguished(steps):
    def digest(value):
        bits = int(np.float64(value).view(np.int64))
        total = 0
        for _ in range(steps):
            total = exchange._digested(total, bits)
        return total

    values = [0.0, -0.0, 1.0, -1.0, 1.0 + 2**-52, 12.0, 0.5]
    digests = [digest(value) for value in values]
    assert len(set(digests)) == len(values), f"commands of {steps} equal steps share a digest: {digests}"
    assert all(0 <= found < 2**63 for found in digests)
