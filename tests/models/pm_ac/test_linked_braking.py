"""Braking into the capacitor of a link without a source: the published example of the package motulator."""

from __future__ import annotations

import numpy as np
import pytest
from tests.models.duty_runs import COLUMN, controlled
from tests.models.schedules import schedule_of

from drivegate_models.loop.schedule import Course, steady
from drivegate_models.machine import ledger
from drivegate_models.machine.load import CONSTANT_TORQUE, Load
from drivegate_models.pm_ac.plant.dc_link import BATTERY, DcLink
from drivegate_models.pm_ac.plant.drive import PmAcDrive, make_pm_ac_drive

PERIOD = 125e-6
BEGIN, END = 108.1, 78.5
"""Speeds of the shaft (rad/s)."""


def example(capacitance: float) -> PmAcDrive:
    """Return the 2.2-kW machine of motulator's examples on a link with a capacitor (F)."""
    return make_pm_ac_drive(
        pole_pairs=3,
        resistance=3.6,
        direct_inductance=0.036,
        quadrature_inductance=0.051,
        magnet_flux=0.545,
        link_voltage=540.0,
        current_limit=9.1,
        inertia=0.015,
        dc_link=DcLink(capacitance, 1.0, BATTERY, 2000.0),
    )


@pytest.mark.parametrize(
    ("capacitance", "before", "after", "highest"),
    [(1e-3, 679.4, 727.2, 740.2), (0.47e-3, 808.3, 892.4, 914.8)],
)
def test_the_kinetic_energy_goes_into_capacitor_and_copper(
    capacitance: float, before: float, after: float, highest: float
) -> None:
    drive = example(capacitance)
    # The source charges the link and is gone from the second control period on.
    supply = Course(np.array([0.0, PERIOD, PERIOD]), np.array([0.5 * before, 0.5 * before, 0.0]))
    schedule = schedule_of(steady(END), 0.0, load=steady(0.0))._replace(supply=supply)
    run = controlled(drive, Load(CONSTANT_TORQUE, 0.0), schedule, 1.0, initial_speed=BEGIN, period=PERIOD)
    assert run.worst_balance < 1e-9
    last = run.trace[-1]
    kinetic = 0.5 * drive.inertia * (BEGIN**2 - last[COLUMN["speed"]] ** 2)
    copper = drive.resistance * run.totals[ledger.SQUARE]
    voltage = last[COLUMN["link"]]
    expected = np.sqrt(before**2 + 2.0 * (kinetic - copper) / capacitance)
    assert voltage == pytest.approx(expected, rel=1e-4), (
        "what the copper leaves of the energy is in the capacitor"
    )
    assert last[COLUMN["speed"]] == pytest.approx(END, rel=5e-3)
    # The published run has another speed controller, so its loss differs, and the peak while the torque ends.
    assert voltage == pytest.approx(after, rel=2e-2)
    assert run.trace[:, COLUMN["link_highest"]].max() == pytest.approx(highest, rel=2e-2)
