"""The closed loop of duty ratios: field-oriented control into weakening, delays, and answers that end a run."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable

import numpy as np
import pytest
from tests.models.duty_runs import COLUMN, PERIOD, controlled, course, limits_of, rating

from drivegate_models.contract.duty.records import DUTY_COMMAND
from drivegate_models.contract.duty.signals import TORQUE_REFERENCE
from drivegate_models.loop.duty_command import BAD_LEG
from drivegate_models.loop.exchange import COMPLETED, NOT_FINITE, STOPPED
from drivegate_models.loop.loop_inputs import SteppedController
from drivegate_models.loop.schedule import Course, steady
from drivegate_models.machine import ledger
from drivegate_models.machine.load import CONSTANT_POWER, CONSTANT_TORQUE, LOCKED, Load
from drivegate_models.pm_ac import loop_kernel
from drivegate_models.pm_ac.closed_loop import prepared_duty_loop
from drivegate_models.pm_ac.loop_inputs import DutyLoopInputs
from drivegate_models.pm_ac.oracle import CURRENT, least_at
from drivegate_models.pm_ac.plant.drive import Modulator, PmAcDrive

Factory = Callable[..., PmAcDrive]
_STEP = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)


@pytest.mark.parametrize("modulator", [Modulator(), Modulator(dead_time=2e-6), Modulator(updates=2)])
@pytest.mark.parametrize("machine", ["interior", "surface"])
def test_it_goes_from_standstill_to_three_times_base_speed_at_constant_power(
    machine: str, modulator: Modulator, request: pytest.FixtureRequest
) -> None:
    drive = request.getfixturevalue(machine)(modulator=modulator)
    base, power = rating(drive)
    duration = 1.5 if machine == "interior" else 3.0
    reference = Course(np.array([0.0, 0.5 * duration]), np.array([0.0, 3.0 * base]))
    # Rated power but for what voltage and current need to be regulated by.
    load = Course(np.array([0.0, 0.65 * duration, 0.65 * duration]), np.array([0.0, 0.0, 1.0]))
    run = controlled(drive, Load(CONSTANT_POWER, 0.9 * power), course(drive, reference, load), duration)
    assert run.status == COMPLETED
    trace = run.trace
    late = trace[-2000:]
    error = np.max(np.abs(late[:, COLUMN["speed"]] / (3.0 * base) - 1.0))
    assert error < 2e-3, f"the speed at the end is off by {error:.1e} of three times base speed"
    torque = late[:, COLUMN["torque"]].mean()
    assert torque == pytest.approx(0.9 * power / (3.0 * base), rel=1e-2)
    peak = trace[:, COLUMN["peak_current"]].max() / drive.current_limit
    assert peak < 1.05, f"the current exceeds its limit: {peak:.3f}"
    early = trace[: int(0.1 * len(trace))]
    lag = np.max(np.abs(early[:, COLUMN["speed_reference"]] - early[:, COLUMN["speed"]]))
    assert lag < 0.1 * base, "below base speed it follows the ramp"
    assert run.worst_balance < 1e-9
    # The oracle's least current is not far below what weakening takes.
    least = least_at(drive, limits_of(drive), 3.0 * base, torque, CURRENT)
    found = math.hypot(late[:, COLUMN["direct"]].mean(), late[:, COLUMN["quadrature"]].mean())
    assert found < 1.12 * least.current


def test_it_takes_least_current_below_base_speed(interior: Factory) -> None:
    drive = interior()
    base, _ = rating(drive)
    speed, torque = 0.5 * base, 1.2
    loaded = controlled(
        drive,
        Load(CONSTANT_TORQUE, torque),
        course(drive, steady(speed), steady(1.0)),
        1.0,
        initial_speed=speed,
    )
    assert loaded.status == COMPLETED
    late = loaded.trace[-1000:]
    assert late[:, COLUMN["torque"]].mean() == pytest.approx(torque, rel=1e-3)
    least = least_at(drive, limits_of(drive), speed, torque, CURRENT)
    assert late[:, COLUMN["direct"]].mean() == pytest.approx(least.direct, abs=0.1)
    found = math.hypot(late[:, COLUMN["direct"]].mean(), late[:, COLUMN["quadrature"]].mean())
    assert found == pytest.approx(least.current, rel=1e-2)


@pytest.mark.parametrize("angle", np.linspace(0.0, 2.0 * math.pi, 5)[:-1])
def test_it_gives_a_torque_within_milliseconds_from_any_angle(interior: Factory, angle: float) -> None:
    drive = interior()
    reference = Course(np.array([0.0, 0.005, 0.005]), np.array([0.0, 0.0, 1.5]))
    run = controlled(
        drive,
        Load(CONSTANT_TORQUE, 5.0),
        course(drive, reference, steady(1.0)),
        0.03,
        reference_kind=TORQUE_REFERENCE,
        initial_angle=angle,
    )
    torque = run.trace[:, COLUMN["torque"]]
    begin = round(0.005 / PERIOD)
    rise = int(np.argmax(torque > 0.9 * 1.5)) - begin
    assert 0 < rise * PERIOD <= 4e-3, f"90 % of the torque takes {rise} periods"
    assert torque[-50:].mean() == pytest.approx(1.5, rel=5e-3)
    assert torque.max() < 1.15 * 1.5
    assert not run.trace[:, COLUMN["speed"]].any(), "a load of more torque holds the shaft"


def stubborn(*values: float, leg: int = 1, size: int | None = None) -> tuple[object, int]:
    """Return a controller that always answers the same, and the address of its step."""

    def step(_state: int, _sense: int, command: int) -> None:
        buffer = (ctypes.c_char * DUTY_COMMAND.itemsize).from_address(command)
        record = np.frombuffer(buffer, DUTY_COMMAND)
        record.flags.writeable = True
        record["first_leg"] = leg
        for name, value in zip(("first_duty", "second_duty", "third_duty"), values, strict=True):
            record[name] = value
        if size is not None:
            record["struct_size"] = size

    kept = _STEP(step)
    return kept, int(ctypes.cast(kept, ctypes.c_void_p).value or 0)


@pytest.mark.parametrize(
    ("controller", "status"),
    [
        (stubborn(0.5, 0.5, math.nan), NOT_FINITE),
        (stubborn(0.5, 0.5, 0.5, leg=7), BAD_LEG),
        (stubborn(0.5, 0.5, 0.5, size=-1), STOPPED),
        (stubborn(0.5, 0.5, 0.5), COMPLETED),
    ],
)
def test_an_answer_that_is_none_ends_the_run(
    interior: Factory, controller: tuple[object, int], status: int
) -> None:
    drive = interior()
    run = prepared_duty_loop(
        DutyLoopInputs(
            drive=drive,
            load=Load(CONSTANT_TORQUE, 0.0),
            schedule=course(drive, steady(1.0), steady(1.0)),
            control_period=PERIOD,
            duration=10 * PERIOD,
        ),
        SteppedController(controller[1], 0),
    ).run()
    assert run.status == status
    assert run.steps == (10 if status == COMPLETED else 0)


@pytest.mark.parametrize(("delay", "silent"), [(0, 0), (1, 1)])
def test_an_answer_acts_after_its_delay(interior: Factory, delay: int, silent: int) -> None:
    drive = interior(modulator=Modulator(update_delay=delay))
    kept, address = stubborn(0.9, 0.1, 0.1)
    run = prepared_duty_loop(
        DutyLoopInputs(
            drive=drive,
            load=Load(CONSTANT_TORQUE, 100.0),
            schedule=course(drive, steady(0.0), steady(1.0)),
            control_period=PERIOD,
            duration=4 * PERIOD,
        ),
        SteppedController(address, 0),
    ).run()
    assert kept is not None
    flows = run.trace[:, COLUMN["peak_current"]] > 0.1
    assert list(flows) == [k >= silent for k in range(4)]


def test_speed_frozen_at_the_middle_converges_with_the_square_of_the_period(interior: Factory) -> None:
    """Frozen at the start of each period it would with the period itself."""
    drive = interior(inertia=2e-4)
    kept, address = stubborn(0.0, 0.0, 0.0)

    def coasted(period: float) -> float:
        run = prepared_duty_loop(
            DutyLoopInputs(
                drive=drive,
                load=Load(CONSTANT_TORQUE, 0.0),
                schedule=course(drive, steady(0.0), steady(1.0)),
                control_period=period,
                duration=0.0405,
                initial_speed=100.0,
            ),
            SteppedController(address, 0),
        ).run()
        return float(np.interp(0.04, run.trace[:, COLUMN["time"]], run.trace[:, COLUMN["speed"]]))

    drive = drive._replace(modulator=drive.modulator._replace(update_delay=0))
    exact = coasted(1e-5)
    coarse, fine = abs(coasted(5e-4) - exact), abs(coasted(1.25e-4) - exact)
    assert kept is not None
    assert fine < coarse / 8.0, f"a quarter of the period leaves {fine / coarse:.2f} of the error"


def test_the_same_run_gives_the_same_bits(interior: Factory) -> None:
    drive = interior(modulator=Modulator(dead_time=2e-6))
    runs = [
        controlled(drive, Load(CONSTANT_TORQUE, 0.5), course(drive, steady(100.0), steady(1.0)), 0.1)
        for _ in range(2)
    ]
    assert runs[0].trace.tobytes() == runs[1].trace.tobytes()
    assert runs[0].totals[ledger.EVENTS] == runs[1].totals[ledger.EVENTS]


def test_of_energies_that_are_but_rounding_none_is_missed_and_any_other_is() -> None:
    rated, period = 1.0, np.zeros(ledger.ENTRIES)
    for missed, balanced in ((1e-17, True), (1e-12, False)):
        period[ledger.UPPER] = period[ledger.EXCHANGED] = missed * rated
        balance = loop_kernel._balance(0.5, 0.0, 0.0, 0.0, rated, period)
        assert (balance < 1e-9) is balanced, f"{missed:g} of what is rated is {balance:g} of the throughput"


def test_duty_ratios_hold_over_all_carrier_periods_of_a_control_period(interior: Factory) -> None:
    every, kept = 4, stubborn(0.7, 0.4, 0.3)

    def held(modulator: Modulator, period: float) -> np.ndarray:
        drive = interior(modulator=modulator)
        run = prepared_duty_loop(
            DutyLoopInputs(
                drive=drive,
                load=Load(LOCKED, 0.0),
                schedule=course(drive, steady(200.0), steady(1.0)),
                control_period=period,
                duration=8 * every * PERIOD,
            ),
            SteppedController(kept[1], 0),
        ).run()
        assert run.worst_balance < 1e-9
        return run.trace

    each = held(Modulator(update_delay=0, dead_time=2e-6), PERIOD)
    both = held(Modulator(update_delay=0, dead_time=2e-6, control_every=every), every * PERIOD)
    assert len(both) == 8
    for name in ("direct", "quadrature"):
        assert both[:, COLUMN[name]] == pytest.approx(each[every - 1 :: every, COLUMN[name]], rel=1e-9)
    for name in ("torque", "input_power"):
        means = each[:, COLUMN[name]].reshape(8, every).mean(axis=1)
        assert both[:, COLUMN[name]] == pytest.approx(means, rel=1e-9)
    assert both[:, COLUMN["peak_current"]].max() == pytest.approx(each[:, COLUMN["peak_current"]].max())
    # Held over all of it, one pulse as long as the control period would make more ripple.
    whole = held(Modulator(update_delay=0, dead_time=2e-6), every * PERIOD)
    assert whole[0, COLUMN["peak_current"]] != pytest.approx(both[0, COLUMN["peak_current"]], rel=1e-3)
