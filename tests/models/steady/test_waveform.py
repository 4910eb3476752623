"""Waveforms agree with the plant's exact means and with its differential equation."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from drivegate_models.half_bridge.plant.drive import Drive
from drivegate_models.steady.steady_state import steady_state
from drivegate_models.steady.waveform import Waveforms, periodic_waveforms

POINTS = [(1500.0, 11.386, 52.5, 0.0), (1200.0, 11.7, 40.0, 0.25), (400.0, 8.0, 0.0, 0.25)]


@pytest.fixture(params=POINTS, ids=lambda point: f"{point[0]:.0f}rpm-h{point[3]}")
def case(
    request: pytest.FixtureRequest, motor: Callable[..., Drive], rpm: Callable[[float], float]
) -> tuple[Drive, float, float, float, Waveforms]:
    speed_rpm, reference, advance_deg, band = request.param
    drive = motor(hysteresis_band=band)
    speed, advance = rpm(speed_rpm), np.radians(advance_deg)
    return drive, speed, reference, advance, periodic_waveforms(drive, speed, reference, advance)


Case = tuple[Drive, float, float, float, Waveforms]


def test_torque_has_the_exact_mean_and_extremes(case: Case) -> None:
    drive, speed, reference, advance, waves = case
    exact = steady_state(drive, speed, reference, advance)
    mean = np.trapezoid(waves.torque, waves.times) / waves.cycle
    assert mean == pytest.approx(exact.torque, rel=1e-4), "the sampled torque misses the exact mean"
    assert waves.torque.min() >= exact.torque_lowest - 1e-9, "a sample lies below the exact least torque"
    assert waves.torque.max() <= exact.torque_highest + 1e-9, "a sample lies above the exact greatest torque"
    assert waves.torque.min() == pytest.approx(exact.torque_lowest, rel=1e-3)
    assert waves.torque.max() == pytest.approx(exact.torque_highest, rel=1e-3)


def test_current_sum_and_peak_are_those_of_the_steady_state(case: Case) -> None:
    drive, speed, reference, advance, waves = case
    exact = steady_state(drive, speed, reference, advance)
    current_sum = np.trapezoid(np.abs(waves.currents).sum(axis=0), waves.times) / waves.cycle
    assert current_sum == pytest.approx(exact.current_sum, rel=1e-3)
    assert np.abs(waves.currents).max() == pytest.approx(exact.current_peak, rel=1e-3)


def test_samples_solve_the_voltage_equation(case: Case) -> None:
    """Over each short interval L di equals the mean of v - R i - e times its length (paper, equation 1)."""
    drive, speed, _, _, waves = case
    steps = np.diff(waves.times)
    driving = waves.voltages - drive.resistance * waves.currents - drive.emf_constant * speed * waves.shapes
    # The voltage at a step is the value before it, so an interval has the voltage of its end.
    emf_and_drop = (waves.voltages - driving)[:, :-1]
    expected = (waves.voltages[:, 1:] - 0.5 * (emf_and_drop + (waves.voltages - driving)[:, 1:])) * steps
    change = drive.inductance * np.diff(waves.currents, axis=1)
    conducting = (waves.currents[:, :-1] != 0.0) & (waves.currents[:, 1:] != 0.0) & (steps > 1e-9)
    sliding = np.diff(waves.currents, axis=1) == 0.0
    error = np.abs(change - expected)[conducting & ~sliding]
    scale = drive.inductance * np.abs(waves.currents).max()
    assert error.size > 500, "too few samples conduct for the test to mean anything"
    assert error.max() < 2e-5 * scale, f"the current does not follow its equation: {error.max() / scale:.2e}"


def test_cycle_closes_and_its_halves_mirror_each_other(case: Case) -> None:
    waves = case[-1]
    assert waves.certified, "the point is periodic"
    np.testing.assert_allclose(waves.currents[:, 0], waves.currents[:, -1], atol=1e-9)
    grid = np.linspace(0.0, 0.5, 60, endpoint=False) * waves.cycle
    for current in waves.currents:
        first = np.interp(grid, waves.times, current)
        second = np.interp(grid + 0.5 * waves.cycle, waves.times, current)
        np.testing.assert_allclose(first, -second, atol=0.02, err_msg="the half waves differ")


def test_times_cover_one_electrical_cycle(case: Case) -> None:
    drive, speed, _, _, waves = case
    assert waves.cycle == pytest.approx(2.0 * np.pi / (drive.pole_pairs * speed))
    assert waves.times[0] == 0.0
    assert waves.times[-1] == pytest.approx(waves.cycle)
    assert (np.diff(waves.times) >= 0.0).all(), "the times run backward"
    assert waves.angles[-1] == pytest.approx(2.0 * np.pi)
    assert waves.currents.shape == waves.shapes.shape == waves.voltages.shape == (5, waves.times.size)
