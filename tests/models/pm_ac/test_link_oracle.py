"""The oracle of a dc link against a grid of all currents, and foc against the oracle."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.models.duty_runs import COLUMN, controlled
from tests.models.schedules import schedule_of

from drivegate_models.loop.exchange import COMPLETED
from drivegate_models.loop.schedule import Course, steady
from drivegate_models.machine.load import CONSTANT_TORQUE, Load
from drivegate_models.pm_ac.link_oracle import (
    BRAKING,
    DRIVING,
    greatest_on_link,
    least_power,
    link_voltage,
    most_power,
)
from drivegate_models.pm_ac.plant.dc_link import BATTERY, RECTIFIER, DcLink
from drivegate_models.pm_ac.plant.drive import Modulator, PmAcDrive, make_pm_ac_drive

PERIOD = 50e-6
SUPPLY = DcLink(1e-3, 0.1, RECTIFIER, 60.0, 0.0, 7.3)
PACK = DcLink(1e-3, 0.1, BATTERY, 60.0, 2.0, 7.3)
BURNER = DcLink(1e-3, 0.1, RECTIFIER, 60.0, 0.0, 7.3, 56.0, 54.0, 0.03)


def servo(link: DcLink, **changes: float) -> PmAcDrive:
    """Return the servo motor of 48 V on a link."""
    constants = {
        "resistance": 0.394,
        "direct_inductance": 0.1904e-3,
        "quadrature_inductance": 0.1904e-3,
        "magnet_flux": 6.356e-3,
        "link_voltage": 48.0,
        "current_limit": 12.0,
        "inertia": 6e-5,
    }
    return make_pm_ac_drive(
        pole_pairs=4, modulator=Modulator(dead_time=0.2e-6), dc_link=link, **(constants | changes)
    )


def on_a_grid(drive: PmAcDrive, speed: float, sign: float) -> float:
    """Return the greatest torque in a direction over a grid of currents; nothing of the oracle is used."""
    link, electrical = drive.dc_link, drive.pole_pairs * speed
    direct, quadrature = np.meshgrid(np.linspace(-12.0, 12.0, 1201), np.linspace(-12.0, 12.0, 1201))
    flux_d = drive.direct_inductance * direct + drive.magnet_flux
    flux_q = drive.quadrature_inductance * quadrature
    along = drive.resistance * direct - electrical * flux_q
    across = drive.resistance * quadrature + electrical * flux_d
    torque = 1.5 * drive.pole_pairs * (flux_d * quadrature - flux_q * direct)
    core = 1.5 * drive.core_loss_conductance * electrical**2 * (flux_d**2 + flux_q**2)
    power = torque * speed + 1.5 * drive.resistance * (direct**2 + quadrature**2) + core
    source, resistance = drive.link_voltage, link.source_resistance
    most = (source - resistance * link.discharge_limit) * link.discharge_limit
    least = -(source + resistance * link.charge_limit) * link.charge_limit
    least -= link.chopper_conductance * link.chopper_on**2
    voltage = 0.5 * (source + np.sqrt(np.maximum(source**2 - 4.0 * resistance * power, 0.0)))
    if link.source == RECTIFIER:
        voltage = np.where(power < 0.0, link.chopper_off or source, voltage)
    inside = (np.hypot(direct, quadrature) <= drive.current_limit) & (power <= most) & (power >= least)
    inside &= np.hypot(along, across) <= voltage / math.sqrt(3.0)
    return float(np.max(np.where(inside, sign * torque, -np.inf)))


@pytest.mark.one_in(5)
@pytest.mark.parametrize("saliency", [1.0, 2.5])
@pytest.mark.parametrize("speed", [100.0, 470.0, 900.0])
@pytest.mark.parametrize("link", [SUPPLY, PACK, BURNER], ids=["supply", "battery", "chopper"])
def test_the_greatest_torques_are_those_of_a_grid_of_all_currents(
    link: DcLink, speed: float, saliency: float
) -> None:
    drive = servo(link, quadrature_inductance=saliency * 0.1904e-3, core_loss_conductance=1e-3)
    for sign in (DRIVING, BRAKING):
        found = sign * greatest_on_link(drive, 48.0, speed, 12.0, sign, True).torque
        seen = on_a_grid(drive, speed, sign)
        assert seen <= found * (1.0 + 1e-9), "no currents of the grid have more"
        assert found <= 1.02 * seen, "the grid's step of 0.02 A is all between them"


def test_the_link_under_load_takes_the_power_that_the_source_supplies() -> None:
    for power in (0.0, 100.0, -50.0, most_power(PACK, 48.0), least_power(PACK, 48.0)):
        voltage = link_voltage(PACK, 48.0, power)
        assert voltage * (48.0 - voltage) / PACK.source_resistance == pytest.approx(power, abs=1e-9)
    assert link_voltage(PACK, 48.0, 6000.0) == 0.0, "more than E^2/(4 R) is out of reach"
    assert link_voltage(SUPPLY, 48.0, -1.0) == 48.0


@pytest.mark.parametrize("link", [SUPPLY, PACK, BURNER], ids=["supply", "battery", "chopper"])
def test_foc_brakes_within_what_the_link_takes_and_nearly_as_well_as_can_be(link: DcLink) -> None:
    drive = servo(link)
    reference = Course(np.array([0.0, 0.02, 0.02]), np.array([600.0, 600.0, 60.0]))
    schedule = schedule_of(reference, 24.0, load=steady(0.0))
    run = controlled(drive, Load(CONSTANT_TORQUE, 0.0), schedule, 0.4, initial_speed=600.0, period=PERIOD)
    assert run.status == COMPLETED
    assert run.worst_balance < 1e-9
    trace = run.trace
    assert trace[:, COLUMN["link_highest"]].max() <= link.limit
    length = round(0.01 / PERIOD)
    means = np.convolve(trace[:, COLUMN["source_current"]], np.full(length, 1.0 / length), "valid")
    assert means.min() >= -1.05 * link.charge_limit - 1e-9
    assert means.max() <= 1.05 * link.discharge_limit
    speeds = trace[:, COLUMN["speed"]]
    braking = (speeds < 0.85 * 600.0) & (speeds > 150.0)
    assert braking.sum() > 20
    for row in trace[braking][:: max(int(braking.sum() // 12), 1)]:
        most = greatest_on_link(drive, 48.0, float(row[COLUMN["speed"]]), 12.0, BRAKING, True).torque
        assert row[COLUMN["torque"]] <= 0.8 * most, f"{row[COLUMN['torque']]:.4g} of {most:.4g} N m"
    assert speeds[-1] == pytest.approx(60.0, abs=3.0)


def test_a_controller_that_does_not_know_the_link_overcharges_it() -> None:
    drive = servo(SUPPLY)
    reference = Course(np.array([0.0, 0.02, 0.02]), np.array([600.0, 600.0, 60.0]))
    schedule = schedule_of(reference, 24.0, load=steady(0.0))
    unaware = drive._replace(dc_link=DcLink())
    run = controlled(
        drive, Load(CONSTANT_TORQUE, 0.0), schedule, 0.1, initial_speed=600.0, period=PERIOD, known=unaware
    )
    assert run.trace[:, COLUMN["link_highest"]].max() > 1.2 * SUPPLY.limit
