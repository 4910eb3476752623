"""Currents led by prediction: what the model foresees, and how fast a torque is there."""

from __future__ import annotations

import numpy as np
import pytest
from tests.models.duty_runs import COLUMN, held, limits_of, rating
from tests.models.pm_ac.conftest import INTERIOR

from drivegate_models.loop.schedule import Course, steady
from drivegate_models.pm_ac.oracle import greatest_torque
from drivegate_models.pm_ac.plant.drive import Modulator, make_pm_ac_drive

NAME = "predictive-flux"


@pytest.mark.parametrize("update_delay", [0, 1])
@pytest.mark.parametrize("share", [0.1, 1.0, 3.0])
def test_the_flux_of_the_next_sample_is_foreseen(share: float, update_delay: int) -> None:
    drive = make_pm_ac_drive(**INTERIOR, modulator=Modulator(update_delay=update_delay))
    speed = share * rating(drive)[0]
    torque = 0.5 * greatest_torque(drive, limits_of(drive), speed).torque
    run, state = held(drive, NAME, speed, steady(torque))
    assert run.trace[-100:, COLUMN["torque"]].mean() == pytest.approx(torque, rel=1e-2)
    missed = np.hypot(state["direct_missed"][0], state["quadrature_missed"][0]) / limits_of(drive).voltage
    assert missed < 0.01, f"what the model does not explain is {100.0 * missed:.2f} % of the voltage"


def test_what_the_model_does_not_know_leaves_no_error() -> None:
    drive = make_pm_ac_drive(**INTERIOR)
    warm = drive._replace(resistance=1.5 * drive.resistance, magnet_flux=0.9 * drive.magnet_flux)
    run, _ = held(drive, NAME, 0.5 * rating(drive)[0], steady(1.0), plant=warm)
    late = run.trace[-200:]
    saliency = drive.direct_inductance - drive.quadrature_inductance
    direct, quadrature = late[:, COLUMN["direct"]].mean(), late[:, COLUMN["quadrature"]].mean()
    believed = 1.5 * drive.pole_pairs * (drive.magnet_flux + saliency * direct) * quadrature
    assert believed == pytest.approx(1.0, rel=2e-3), "the currents are those of the machine on the nameplate"


def test_a_torque_is_there_within_milliseconds() -> None:
    drive = make_pm_ac_drive(**INTERIOR)
    step = Course(np.array([0.0, 0.02, 0.02]), np.array([0.0, 0.0, 1.0]))
    torque = held(drive, NAME, 0.5 * rating(drive)[0], step)[0].trace[:, COLUMN["torque"]]
    assert np.abs(torque[150:200]).max() < 0.05
    assert np.argmax(torque[200:] > 0.9) < 20, "90 % of it takes less than 2 ms"
    assert torque.max() < 1.1


def test_it_is_another_regulator_than_that_of_foc() -> None:
    drive = make_pm_ac_drive(**INTERIOR)
    first, other = (
        held(drive, name, rating(drive)[0], steady(1.0))[0].commands["first_duty"] for name in ("foc", NAME)
    )
    assert np.abs(first[10:] - other[10:]).max() > 1e-4


@pytest.mark.parametrize("update_delay", [0, 1])
def test_a_step_of_a_machine_of_few_microhenries_moves_no_direct_current(update_delay: int) -> None:
    """Its resistance takes a tenth of a current in a period, in which the rotor turns by 7 degrees."""
    drive = make_pm_ac_drive(
        pole_pairs=7,
        resistance=0.0276,
        magnet_flux=0.0039,
        direct_inductance=2.5e-5,
        quadrature_inductance=2.5e-5,
        link_voltage=24.0,
        current_limit=25.0,
        core_loss_conductance=0.0,
        inertia=1e-4,
        modulator=Modulator(update_delay=update_delay),
    )
    step = Course(np.array([0.0, 0.02, 0.02]), np.array([0.04, 0.04, 0.4]))
    trace = held(drive, NAME, 180.0, step)[0].trace
    direct, quadrature = trace[:, COLUMN["direct"]], trace[:, COLUMN["quadrature"]]
    size = quadrature[-100:].mean() - quadrature[150:200].mean()
    assert size > 5.0
    moved = np.abs(direct[200:300] - direct[-100:].mean()).max()
    assert moved < 0.02 * size, f"{100.0 * moved / size:.1f} % of the step of the quadrature current"
