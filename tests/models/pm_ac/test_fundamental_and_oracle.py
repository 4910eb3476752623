"""Steady states in closed form against published figures, the oracle against both and against the switched plant."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from drivegate_models.machine import ledger
from drivegate_models.pm_ac.fundamental import (
    LINEAR_LIMIT,
    SIX_STEPS,
    base_speed,
    most_torque_per_ampere,
    steady_state,
    steady_voltages,
)
from drivegate_models.pm_ac.oracle import (
    CURRENT,
    LOSS,
    Limits,
    constant_power_end,
    greatest_torque,
    least_at,
    undistorted_limits,
)
from drivegate_models.pm_ac.plant.advance import advance_period, make_phases, stored_energy
from drivegate_models.pm_ac.plant.drive import CENTRED, PmAcDrive, electrical_torque, make_pm_ac_drive

Factory = Callable[..., PmAcDrive]
RPM = math.pi / 30.0
LIBRARY = 2.0 * math.pi * 50.0
"""Frequency at which the Modelica Standard Library states its machine (rad/s)."""


def library_machine() -> PmAcDrive:
    """Return the synchronous machine with permanent magnets of the Modelica Standard Library, by its defaults."""
    return make_pm_ac_drive(
        pole_pairs=2,
        resistance=0.03,
        direct_inductance=0.4 / LIBRARY,
        quadrature_inductance=0.4 / LIBRARY,
        magnet_flux=112.3 * math.sqrt(2.0) / LIBRARY,
        link_voltage=400.0,
        current_limit=200.0,
    )


def small_machine() -> PmAcDrive:
    """Return Anaheim's BLY171D-24V-4000 by the figures that the Motor Control Blockset has of it."""
    return make_pm_ac_drive(
        pole_pairs=4,
        resistance=0.75,
        direct_inductance=1.05e-3,
        quadrature_inductance=1.05e-3,
        # 3.8 V between lines, peak, at 1000/min.
        magnet_flux=3.8 / (math.sqrt(3.0) * 2.0 * math.pi * 1000.0 * 4.0 / 60.0),
        link_voltage=24.0,
        current_limit=1.8,
    )


def limits_of(drive: PmAcDrive) -> Limits:
    return Limits(drive.current_limit, LINEAR_LIMIT * drive.link_voltage)


@pytest.mark.kernel
def test_the_library_machine_gives_the_torque_and_takes_the_voltage_that_it_states() -> None:
    """Modelica.Electrical.Machines, example SMPM_CurrentSource: (-53.5, 84.6) A rms give 181.4 N m at 100 V."""
    root = math.sqrt(2.0)
    state = steady_state(library_machine(), LIBRARY / 2.0, -53.5 * root, 84.6 * root)
    assert state.torque == pytest.approx(181.4, abs=0.05)
    assert state.voltage / root == pytest.approx(100.0, abs=0.1)


@pytest.mark.kernel
def test_the_small_machine_reaches_its_base_speed() -> None:
    drive = small_machine()
    speed = base_speed(drive, 1.8, LINEAR_LIMIT * 24.0)
    assert speed / RPM == pytest.approx(5393.0, abs=0.5), "1.8 A use 24 V over the root of 3 up"


@pytest.mark.kernel
def test_limits_of_the_bridge() -> None:
    assert pytest.approx(1.0 / math.sqrt(3.0)) == LINEAR_LIMIT
    assert pytest.approx(2.0 / math.pi) == SIX_STEPS


@pytest.mark.kernel
@pytest.mark.parametrize("current", [0.0, 1e-9, 1.0, 7.07])
@pytest.mark.parametrize("ratio", [0.4, 1.0, 1.0 + 1e-12, 2.6, 4.0])
def test_most_torque_per_ampere_is_the_published_formula(
    interior: Factory, ratio: float, current: float
) -> None:
    drive = interior(quadrature_inductance=8.72e-3 * ratio)
    direct, quadrature = most_torque_per_ampere(drive, current)
    saliency = drive.quadrature_inductance - drive.direct_inductance
    assert math.hypot(direct, quadrature) == pytest.approx(current, rel=1e-14)
    if abs(ratio - 1.0) > 0.1 and current > 0.1:
        root = math.sqrt(drive.magnet_flux**2 + 8.0 * saliency**2 * current**2)
        assert direct == pytest.approx((drive.magnet_flux - root) / (4.0 * saliency), rel=1e-12)
    torque = electrical_torque(drive, direct, quadrature)
    for turn in np.linspace(-0.4, 0.4, 41):
        other = complex(direct, quadrature) * complex(np.exp(1j * turn))
        assert electrical_torque(drive, other.real, other.imag) <= torque * (1.0 + 1e-12)


@pytest.mark.kernel
def test_without_a_magnet_half_of_the_square_lies_on_each_axis(interior: Factory) -> None:
    direct, quadrature = most_torque_per_ampere(interior(magnet_flux=0.0), 5.0)
    assert abs(direct) == pytest.approx(quadrature, rel=1e-14)


@pytest.mark.kernel
def test_least_current_is_most_torque_per_ampere_below_base_speed(interior: Factory) -> None:
    drive = interior()
    for share in (0.3, 1.0):
        direct, quadrature = most_torque_per_ampere(drive, share * 7.0)
        torque = electrical_torque(drive, direct, quadrature)
        found = least_at(drive, limits_of(drive), 20.0, torque, CURRENT)
        assert found.current == pytest.approx(share * 7.0, rel=1e-9)
        assert found.torque == pytest.approx(torque, rel=1e-12)
    top = greatest_torque(drive, limits_of(drive), 20.0)
    assert top.torque == pytest.approx(
        electrical_torque(drive, *most_torque_per_ampere(drive, 7.07)), rel=1e-9
    )


@pytest.mark.kernel
def test_base_speed_is_where_weakening_begins(interior: Factory) -> None:
    drive = interior()
    limits = limits_of(drive)
    base = base_speed(drive, limits.current, limits.voltage)
    full = greatest_torque(drive, limits, 0.5 * base).torque
    assert greatest_torque(drive, limits, base * (1.0 - 1e-6)).torque == pytest.approx(full, rel=1e-9)
    assert greatest_torque(drive, limits, base * 1.02).torque < full * (1.0 - 1e-4)


@pytest.mark.kernel
def test_least_loss_never_takes_less_current_nor_more_loss_than_least_current(interior: Factory) -> None:
    drive = interior(core_loss_conductance=1.0 / 240.0)
    limits = limits_of(drive)
    for speed in (50.0, 150.0, 400.0):
        most = greatest_torque(drive, limits, speed).torque
        for share in (0.1, 0.5, 0.99):
            frugal = least_at(drive, limits, speed, share * most, CURRENT)
            cool = least_at(drive, limits, speed, share * most, LOSS)
            assert cool.loss <= frugal.loss * (1.0 + 1e-9)
            assert frugal.current <= cool.current * (1.0 + 1e-9)
            assert max(cool.voltage, frugal.voltage) <= limits.voltage * (1.0 + 1e-9)
    lossless = least_at(interior(), limits, 150.0, 1.0, LOSS)
    same = least_at(interior(), limits, 150.0, 1.0, CURRENT)
    assert lossless.direct == pytest.approx(same.direct, abs=1e-6), "without core loss both are one"


@pytest.mark.kernel
def test_no_torque_beyond_the_greatest(surface: Factory) -> None:
    drive = surface()
    limits = limits_of(drive)
    top = greatest_torque(drive, limits, 300.0 * 0.3).torque
    assert least_at(drive, limits, 90.0, top * (1.0 - 1e-9), CURRENT).torque == pytest.approx(top, rel=1e-6)
    assert math.isnan(least_at(drive, limits, 90.0, top * 1.001, CURRENT).torque)


def test_the_range_is_unbounded_where_the_current_can_take_the_whole_flux(interior: Factory) -> None:
    needed = 0.0879 / 8.72e-3
    endless = interior(current_limit=1.01 * needed, resistance=0.0)
    ending = interior(current_limit=0.9 * needed, resistance=0.0)
    power = {}
    for drive in (endless, ending):
        limits = limits_of(drive)
        base = base_speed(drive, limits.current, limits.voltage)
        power[drive] = 0.3 * base * greatest_torque(drive, limits, base).torque
    assert constant_power_end(endless, limits_of(endless), power[endless]) == math.inf
    end = constant_power_end(ending, limits_of(ending), power[ending])
    assert math.isfinite(end)
    there = greatest_torque(ending, limits_of(ending), end)
    assert there.torque * end == pytest.approx(power[ending], rel=1e-6)


def settled(drive: PmAcDrive, speed: float, direct: float, quadrature: float) -> dict[str, float]:
    """Return means over a turn of the switched plant whose reference currents are held by exact voltages."""
    electrical = drive.pole_pairs * speed
    period = 2.0 * math.pi / electrical / 240.0
    phases, totals = make_phases(), np.zeros(ledger.ENTRIES)
    phases.rotor_currents[:] = (direct, quadrature)
    voltages = complex(*steady_voltages(drive, electrical, direct, quadrature))
    # Held over a period while the rotor turns, a voltage has a chord's length of the arc that it stands for.
    half = 0.5 * electrical * period
    stored = stored_energy(drive, phases)
    for k in range(480):
        if k == 240:
            totals[:] = 0.0
            stored = stored_energy(drive, phases)
        angle = k * electrical * period
        vector = voltages * np.exp(1j * (angle + half)) * math.sin(half) / half
        legs = (vector * np.exp(-2j * math.pi / 3.0 * np.arange(3))).real / drive.link_voltage
        ratios = 0.5 + legs - 0.5 * (legs.max() + legs.min())
        advance_period(
            drive,
            phases,
            angle,
            speed,
            drive.link_voltage,
            ratios,
            np.ones(3, np.int64),
            CENTRED,
            period,
            totals,
        )
    time = 240 * period
    return {
        "torque": totals[ledger.IMPULSE] / time,
        "input": (ledger.source_energy(totals) - stored_energy(drive, phases) + stored) / time,
    }


@pytest.mark.kernel
@pytest.mark.parametrize(("speed", "share"), [(60.0, 0.8), (150.0, 0.5), (400.0, 0.7)])
def test_the_switched_plant_gives_what_the_fundamental_says(
    interior: Factory, speed: float, share: float
) -> None:
    drive = interior(core_loss_conductance=1.0 / 240.0)
    limits = limits_of(drive)
    torque = share * greatest_torque(drive, limits, speed).torque
    best = least_at(drive, limits, speed, torque, LOSS)
    means = settled(drive, speed, best.direct, best.quadrature)
    assert means["torque"] == pytest.approx(torque, rel=5e-3)
    loss = means["input"] - means["torque"] * speed
    assert loss == pytest.approx(best.loss, rel=2e-2)


def test_a_sweep_of_the_switched_plant_has_its_least_loss_where_the_oracle_says(interior: Factory) -> None:
    drive = interior(core_loss_conductance=1.0 / 240.0)
    limits = limits_of(drive)
    speed, torque = 150.0, 1.0
    best = least_at(drive, limits, speed, torque, LOSS)
    losses = []
    places = best.direct + np.linspace(-1.5, 1.5, 13)
    for direct in places:
        means = settled(drive, speed, direct, torque / electrical_torque(drive, direct, 1.0))
        losses.append((means["input"] - means["torque"] * speed) / means["torque"])
    coefficients = np.polyfit(places - best.direct, losses, 4)
    fine = np.linspace(-1.5, 1.5, 3001)
    least = fine[np.argmin(np.polyval(coefficients, fine))]
    assert abs(least) < 0.15, f"the plant's least loss lies {least:.3f} A from the oracle's"
    assert min(losses) >= 0.99 * best.loss / torque


def test_two_switches_take_their_drops_from_the_voltage_of_the_link() -> None:
    drive = library_machine()
    dropping = drive._replace(switch_drop=2.0)
    assert undistorted_limits(dropping, 300.0).voltage == pytest.approx(LINEAR_LIMIT * 296.0)
    assert undistorted_limits(drive, 300.0).voltage == pytest.approx(LINEAR_LIMIT * 300.0)
    assert undistorted_limits(dropping, 3.0).voltage == 0.0, "less than nothing cannot be left"
