"""How a run begins: with all legs off, in the steady state that the machine has then."""

from __future__ import annotations

from collections.abc import Callable
from math import pi, sqrt

import numpy as np
import pytest
from tests.models.duty_runs import COLUMN, PERIOD, course
from tests.models.pm_ac.plant.test_independent_solver import BLOCKED, Point, Solver
from tests.models.pm_ac.test_closed_loop import stubborn

from drivegate_models.contract.duty.signals import LEG_PWM
from drivegate_models.loop.exchange import COMPLETED
from drivegate_models.loop.loop_inputs import SteppedController
from drivegate_models.loop.schedule import steady
from drivegate_models.machine import ledger
from drivegate_models.machine.load import LOCKED, Load
from drivegate_models.pm_ac.closed_loop import DutyRun, prepared_duty_loop
from drivegate_models.pm_ac.loop_inputs import DutyLoopInputs
from drivegate_models.pm_ac.plant.advance import PmAcPhases, make_phases
from drivegate_models.pm_ac.plant.drive import Modulator, PmAcDrive
from drivegate_models.pm_ac.rectifying import rectifies, settle_rectifying

Factory = Callable[..., PmAcDrive]
RPM = pi / 30.0


def started(drive: PmAcDrive, rpm: float, *, angle: float = 0.0, period: float = PERIOD) -> DutyRun:
    """Run a controller that always short-circuits the terminals, at a held speed."""
    kept, address = stubborn(0.5, 0.5, 0.5, leg=LEG_PWM)
    run = prepared_duty_loop(
        DutyLoopInputs(
            drive=drive,
            load=Load(LOCKED),
            schedule=course(drive, steady(rpm * RPM), steady(1.0)),
            control_period=period,
            duration=4 * period,
            initial_speed=rpm * RPM,
            initial_angle=angle,
        ),
        SteppedController(address, 0),
    ).run()
    assert kept is not None
    assert run.status == COMPLETED
    return run


def settled(drive: PmAcDrive, rpm: float, angle: float = 0.0) -> tuple[PmAcPhases, np.ndarray]:
    """Return the state and the integrals over a turn, at the nominal link."""
    phases, totals = make_phases(), np.zeros(ledger.ENTRIES)
    nothing = np.zeros(3), np.zeros(3, np.int64)
    status = settle_rectifying(
        drive, phases, angle, rpm * RPM, drive.link_voltage, (1.0, 1.0), PERIOD, *nothing, totals
    )
    assert status == COMPLETED
    return phases, totals


@pytest.mark.parametrize("delay", [0, 1])
def test_no_current_flows_before_the_first_answer_acts(surface: Factory, delay: int) -> None:
    """A machine of 1 uH at 24 V and 50 kHz, whose EMF would drive far more than its limit in a single period."""
    drive = surface(
        direct_inductance=1e-6,
        quadrature_inductance=1e-6,
        resistance=5e-3,
        magnet_flux=1e-3,
        pole_pairs=7,
        link_voltage=24.0,
        current_limit=60.0,
        modulator=Modulator(update_delay=delay),
    )
    peak = started(drive, 15000.0, period=2e-5).trace[:, COLUMN["peak_current"]]
    assert not peak[:delay].any()
    assert peak[delay] > 2.0 * drive.current_limit, "the answers short-circuit the EMF"


def test_below_the_speed_at_which_the_diodes_conduct_there_is_nothing_to_settle(interior: Factory) -> None:
    drive = interior(diode_drop=1.0)
    threshold = (drive.link_voltage + 2.0) / (sqrt(3.0) * drive.pole_pairs * drive.magnet_flux)
    assert not rectifies(drive, 0.999 * threshold, drive.link_voltage)
    assert rectifies(drive, -1.001 * threshold, drive.link_voltage)
    phases, totals = settled(drive, 0.999 * threshold / RPM)
    assert not totals.any()
    assert not phases.currents.any()


@pytest.mark.one_in(3)
@pytest.mark.parametrize("angle", [0.0, 2.0])
@pytest.mark.parametrize("rpm", [4500.0, 9000.0, -6000.0])
def test_the_steady_state_repeats_itself_in_a_simulation_that_shares_no_code(
    interior: Factory, rpm: float, angle: float
) -> None:
    drive = interior(diode_drop=0.8, switch_drop=1.2)
    phases, totals = settled(drive, rpm, angle)
    begin = complex(*phases.rotor_currents)
    assert abs(begin) > 0.0
    periods = 20
    turn = 2.0 * pi / (drive.pole_pairs * abs(rpm) * RPM)
    point = Point(
        rpm,
        currents=(begin.real, begin.imag),
        modes=(BLOCKED,),
        drops=(1.2, 0.8),
        angle=angle,
        link=drive.link_voltage,
        period=turn / periods,
    )
    solver = Solver(drive, point)
    for k in range(periods):
        solver.run_period(k, BLOCKED)
    end = solver.rotor_current(turn, solver.state)
    assert abs(end - begin) < 1e-8 * drive.current_limit
    assert totals[ledger.IMPULSE] == pytest.approx(solver.state[2 + 2], rel=1e-6), "the torque brakes"
    assert totals[ledger.IMPULSE] * rpm < 0.0


def test_a_run_begins_in_that_state_and_counts_nothing_of_the_way_there(interior: Factory) -> None:
    drive, rpm = interior(), 6000.0
    phases, totals = settled(drive, rpm, 1.0)
    run = started(drive, rpm, angle=1.0)
    assert run.trace[0, COLUMN["angle"]] == 1.0
    first = run.trace[0, COLUMN["peak_current"]]
    assert 0.0 < first <= totals[ledger.PEAK] * (1.0 + 1e-9)
    assert run.trace[0, COLUMN["time"]] == 0.0
    assert run.worst_balance < 1e-9
    assert run.totals[ledger.IMPULSE] == pytest.approx(
        PERIOD * run.trace[:, COLUMN["torque"]].sum(), rel=1e-12
    )
    again = started(drive, rpm, angle=1.0)
    assert run.trace.tobytes() == again.trace.tobytes()
    assert phases.rotor_currents[1] < 0.0
