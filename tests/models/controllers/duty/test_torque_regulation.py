"""Torque and flux regulated in the flux's own frame: the machine's slopes, its pull-out, and how a torque comes."""

from __future__ import annotations

from math import cos, pi, sin
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.models.duty_runs import COLUMN, held, limits_of, rating
from tests.models.pm_ac.conftest import INTERIOR, SURFACE

from drivegate_models.controllers.duty.state import foc_state
from drivegate_models.controllers.duty.torque_regulation import _limited_to_pull_out, _slopes
from drivegate_models.loop.schedule import Course, steady
from drivegate_models.pm_ac.oracle import greatest_torque
from drivegate_models.pm_ac.plant.drive import Modulator, PmAcDrive, make_pm_ac_drive

NAME = "direct-torque"
MACHINES = {"interior": make_pm_ac_drive(**INTERIOR), "surface": make_pm_ac_drive(**SURFACE)}
MACHINE = pytest.mark.parametrize("kind", MACHINES)


def constants_of(drive: PmAcDrive) -> Any:
    """Return a state with a machine's constants."""
    state: Any = foc_state(NAME).view(np.recarray)[0]
    for name in ("pole_pairs", "direct_inductance", "quadrature_inductance", "magnet_flux"):
        state[name] = getattr(drive, name)
    return state


def torque_of(drive: PmAcDrive, flux: float, angle: float | NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the torque of a stator flux at load angles."""
    x, y = flux * np.cos(angle), flux * np.sin(angle)
    direct, quadrature = (x - drive.magnet_flux) / drive.direct_inductance, y / drive.quadrature_inductance
    return np.asarray(1.5 * drive.pole_pairs * (x * quadrature - y * direct))


@pytest.mark.kernel
@MACHINE
@pytest.mark.parametrize("angle", [-1.2, 0.0, 0.7, 1.9])
@pytest.mark.parametrize("share", [0.4, 1.0, 1.7])
def test_slopes_are_those_of_the_torque(kind: str, angle: float, share: float) -> None:
    drive = MACHINES[kind]
    state = constants_of(drive)
    flux, step = share * drive.magnet_flux, 1e-6
    found = _slopes(state, flux, cos(angle), sin(angle))
    by_angle = torque_of(drive, flux, angle + step) - torque_of(drive, flux, angle - step)
    by_flux = torque_of(drive, flux + step, angle) - torque_of(drive, flux - step, angle)
    assert found == pytest.approx((by_angle / (2.0 * step), by_flux / (2.0 * step)), rel=1e-6, abs=1e-6)


@pytest.mark.kernel
@MACHINE
@pytest.mark.parametrize("share", [0.4, 1.0, 1.7])
@pytest.mark.parametrize("sense", [-1.0, 1.0])
def test_no_step_of_the_angle_passes_the_greatest_torque(kind: str, share: float, sense: float) -> None:
    drive = MACHINES[kind]
    state = constants_of(drive)
    flux = share * drive.magnet_flux
    angles = np.linspace(0.0, pi, 100_001)
    pull_out = float(angles[np.argmax(torque_of(drive, flux, angles))])

    def step_from(angle: float, step: float) -> float:
        found = _limited_to_pull_out(state, flux, cos(sense * angle), sin(sense * angle), sense * step)
        return sense * float(found)

    assert step_from(pull_out, 1.0) == pytest.approx(0.0, abs=1e-3)
    assert 0.0 < step_from(pull_out - 0.3, 1.0) <= 0.3
    assert step_from(pull_out + 0.3, 1.0) < -0.2, "beyond, the angle is taken back"
    assert step_from(pull_out - 0.3, 0.1) == pytest.approx(0.1), "short of it nothing is taken"


@MACHINE
@pytest.mark.parametrize("update_delay", [0, 1])
def test_a_torque_comes_in_time_and_moves_the_d_current_along_its_way_alone(
    kind: str, update_delay: int
) -> None:
    drive = MACHINES[kind]._replace(modulator=Modulator(update_delay=update_delay))
    speed = 0.3 * rating(drive)[0]
    end = 0.3 * greatest_torque(drive, limits_of(drive), speed).torque
    step = Course(np.array([0.0, 0.02, 0.02]), np.array([0.0, 0.0, end]))
    trace = held(drive, NAME, speed, step)[0].trace[150:]
    torque, direct, quadrature = (trace[:, COLUMN[name]] for name in ("torque", "direct", "quadrature"))
    assert np.argmax(torque[50:] > 0.9 * end) < 14, "90 % of it takes less than 1.4 ms"
    assert torque.max() < 1.03 * end
    outside = max(direct.max() - max(direct[0], direct[-1]), min(direct[0], direct[-1]) - direct.min())
    share = outside / quadrature[-1]
    assert share < 0.05, f"the d current leaves its way by {100.0 * share:.1f} % of the q current's step"


def test_what_the_model_does_not_know_leaves_no_error() -> None:
    drive = MACHINES["interior"]
    warm = drive._replace(resistance=1.5 * drive.resistance, magnet_flux=0.9 * drive.magnet_flux)
    late = held(drive, NAME, 0.5 * rating(drive)[0], steady(1.0), plant=warm)[0].trace[-200:]
    saliency = drive.direct_inductance - drive.quadrature_inductance
    direct, quadrature = late[:, COLUMN["direct"]].mean(), late[:, COLUMN["quadrature"]].mean()
    believed = 1.5 * drive.pole_pairs * (drive.magnet_flux + saliency * direct) * quadrature
    assert believed == pytest.approx(1.0, rel=2e-3), "the torque is that of the machine on the nameplate"


@MACHINE
def test_a_torque_out_of_reach_pulls_no_flux_out(kind: str) -> None:
    drive = MACHINES[kind]
    speed = 3.0 * rating(drive)[0]
    greatest = greatest_torque(drive, limits_of(drive), speed).torque
    late = held(drive, NAME, speed, steady(3.0 * greatest))[0].trace[-200:]
    share = late[:, COLUMN["torque"]].mean() / greatest
    assert 0.95 < share < 1.01, f"{100.0 * share:.1f} % of the greatest torque"
