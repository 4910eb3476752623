"""motulator's control systems behave on drivegate's plant as in motulator's own simulation of the same drive."""

from __future__ import annotations

from math import pi
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from motulator.common.model import SolverCfg
from motulator.drive import model
from numpy.typing import NDArray

from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import judged
from drivegate.containment.judge import own_candidate
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.duty.scenarios.building import torque_scenario
from drivegate.drives.running import recorded
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.load import ConstantTorqueLoad
from drivegate_cases.scenario.scenario import Scenario

HERE = Path(__file__).parent
SPEED = 314.0
LOAD_NM, LOAD_AT_S, END_S = 5.0, 0.4, 0.5


class Signals(NamedTuple):
    """What is compared, at the end of each control period, shape (n,)."""

    speed: NDArray[np.float64]
    """(rad/s)."""
    current: NDArray[np.complex128]
    """Of the rotor frame (A)."""
    torque: NDArray[np.float64]
    """(N m)."""


def scenario(dead_time_s: float) -> Scenario:
    """From standstill to more than twice base speed, and a load there; motulator's machine has no core loss."""
    overrides = [f"dead_time_s={dead_time_s}", "core_loss_conductance_s=0"]
    drive = load_drive("pm-ac-2kw").with_overrides(overrides)
    # A load that begins with a control period; rounding must not let it miss the first one.
    begin = LOAD_AT_S - 1e-9
    factor = ((0.0, 0.0), (begin, 0.0), (begin, 1.0))
    return Scenario(
        name="motulator",
        drive=drive,
        duration_s=END_S,
        initial_speed_rpm=0.0,
        speed_rpm=((0.0, SPEED * 30.0 / pi),),
        load=ConstantTorqueLoad(kind="constant_torque", torque_nm=LOAD_NM, factor=factor),
    )


def on_our_plant(candidate: str, run: Scenario) -> Signals:
    """Run a candidate on drivegate's plant."""
    loaded = own_candidate(resolve_candidate(str(HERE / candidate)))
    trace = recorded(loaded, run, loaded.controller()).run.column
    machine = run.drive.plant()
    direct, quadrature = trace("direct")[:-1], trace("quadrature")[:-1]
    saliency = machine.direct_inductance - machine.quadrature_inductance
    torque = 1.5 * machine.pole_pairs * (machine.magnet_flux + saliency * direct) * quadrature
    return Signals(trace("speed")[1:], direct + 1j * quadrature, torque)


def by_its_own_simulation(candidate: str, run: Scenario) -> Signals:
    """Simulate the same controller by motulator, with tolerances far below what is compared."""
    loaded = own_candidate(resolve_candidate(str(HERE / candidate)))
    front: Any = loaded.controller().instance
    front.reset(run.drive.duty_nameplate(run.control_period_s, torque_reference=False))
    front.system.set_speed_ref(SPEED)
    plant = run.drive.plant()
    machine = front.system.vector_ctrl.par
    drive = model.Drive(
        model.SynchronousMachine(machine),
        model.MechanicalSystem(J=plant.inertia),
        model.VoltageSourceConverter(u_dc=plant.link_voltage, t_d=plant.modulator.dead_time),
        pwm=True,
    )
    drive.mechanics.set_external_load_torque(lambda time: LOAD_NM * (time > LOAD_AT_S - 1e-9))
    exact = SolverCfg(method="DOP853", rtol=1e-9, atol=1e-10)
    found = model.Simulation(drive, front.system, show_progress=False, cfg=exact).simulate(t_stop=END_S).mdl
    ends = np.arange(1, run.control_periods) * run.control_period_s
    rows = np.searchsorted(found.t, ends - 1e-10)
    return Signals(found.mechanics.w_M[rows], found.machine.i_s_dq[rows], found.machine.tau_M[rows])


@pytest.mark.parametrize(
    ("candidate", "dead_time_s", "speed", "current", "torque"),
    [
        ("current_vector.toml", 0.0, 0.002, 0.0015, 0.003),
        ("flux_vector.toml", 0.0, 0.004, 0.005, 0.007),
        # During dead time motulator holds the sign that a current had at its start, and drivegate follows the current.
        ("current_vector.toml", 2e-6, 0.015, 0.041, 0.041),
    ],
)
def test_trajectories_agree(
    candidate: str, dead_time_s: float, speed: float, current: float, torque: float
) -> None:
    """No signal is further from motulator's at any control period than the bar."""
    run = scenario(dead_time_s)
    ours, theirs = on_our_plant(candidate, run), by_its_own_simulation(candidate, run)
    assert ours.speed[-1] == pytest.approx(SPEED, rel=0.05), "the machine runs far above its base speed"
    worst = [float(np.max(np.abs(mine - other))) for mine, other in zip(ours, theirs, strict=True)]
    differences = "{:.4f} rad/s, {:.4f} A, {:.4f} N·m".format(*worst)
    assert all(error < bar for error, bar in zip(worst, (speed, current, torque), strict=True)), differences
    print(f"{candidate}, dead time {dead_time_s:g} s: at most {differences}")


@pytest.mark.parametrize(
    ("candidate", "is_in_time"), [("current_vector.toml", False), ("fast_current_vector.toml", True)]
)
def test_bandwidths_decide_whether_a_step_is_followed_in_time(candidate: str, is_in_time: bool) -> None:
    """Only with bandwidths of its own parameters raised does current-vector control meet the drive's limit."""
    drive = load_drive("pm-ac-2kw").replaced(settling_s=0.1)
    assert isinstance(drive, PmAcDocument)
    loaded = own_candidate(resolve_candidate(str(HERE / candidate)))
    step = torque_scenario(drive, 390.0, (0.0, 3.2))
    margins = judged(recorded(loaded, step, loaded.controller()), contract_of(drive).checks).margins
    found = {margin.check: margin for margin in margins}
    assert found["STP-1"].met is is_in_time, found["STP-1"].measured
    assert found["DEC-1"].met, found["DEC-1"].measured
    assert found["OVC-1"].met, found["OVC-1"].measured
