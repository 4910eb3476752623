"""Drops of switches and diodes in closed loop: regulators have nothing to make up for."""

from __future__ import annotations

import numpy as np
import pytest
from tests.models.duty_runs import COLUMN, held, rating
from tests.models.pm_ac.conftest import INTERIOR

from drivegate_models.loop.schedule import steady
from drivegate_models.pm_ac.plant.drive import make_pm_ac_drive


@pytest.mark.parametrize("name", ["foc", "predictive-flux", "direct-torque"])
@pytest.mark.parametrize("share", [-0.4, 0.1, 0.6])
def test_drops_leave_the_regulators_nothing_to_make_up_for(name: str, share: float) -> None:
    """Their first harmonic alone is 1.9 V."""
    found = {}
    for drops in ((0.0, 0.0), (1.6, 1.4)):
        drive = make_pm_ac_drive(**INTERIOR, switch_drop=drops[0], diode_drop=drops[1])
        run, state = held(drive, name, share * rating(drive)[0], steady(1.0))
        assert run.trace[-200:, COLUMN["torque"]].mean() == pytest.approx(1.0, rel=5e-3)
        missed = state["direct_missed"][0], state["quadrature_missed"][0]
        found[drops] = np.array([state["direct_integral"][0], state["quadrature_integral"][0], *missed])
    difference = np.abs(found[1.6, 1.4] - found[0.0, 0.0]).max()
    assert difference < 0.3, f"{difference:.2f} V are left"
