"""The torque's swing, on a surface machine at standstill, where it follows from one inductance by hand."""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt

import numpy as np
import pytest

from drivegate_models.contract.duty.signals import LEG_OFF, LEG_PWM
from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.pm_ac.ripple import commanded_swing

pytestmark = pytest.mark.kernel

PERIOD = 1e-4
LINK = 96.0
Factory = Callable[..., PmAcDrive]


def torque_of(drive: PmAcDrive, quadrature: float) -> float:
    """Return the torque of a current across the magnet's axis."""
    return 1.5 * drive.pole_pairs * drive.magnet_flux * quadrature


def swing_of(
    drive: PmAcDrive, ratios: tuple[float, float, float], periods: int = 1, mode: int = LEG_PWM
) -> float:
    """Return the swing from standstill without current, of the last of so many equal periods."""
    return commanded_swing(
        drive,
        (0.0, 0.0),
        0.0,
        0.0,
        np.full(periods, LINK),
        np.tile(ratios, (periods, 1)),
        np.full((periods, 3), mode, np.int64),
        first=0,
        ignored=periods - 1,
        period=PERIOD,
    )


@pytest.mark.parametrize("share", [0.1, 0.3])
def test_a_voltage_across_the_magnet_swings_the_torque_by_its_time_over_the_inductance(
    share: float, surface: Factory
) -> None:
    drive = surface(resistance=0.0)
    # For twice this share of the period one of the other two legs alone is on the upper rail.
    on = 2.0 * share * PERIOD
    expected = torque_of(drive, LINK / sqrt(3.0) / drive.quadrature_inductance * on)
    assert swing_of(drive, (0.5, 0.5 + share, 0.5 - share)) == pytest.approx(expected, rel=1e-12)


def test_what_is_ignored_is_not_looked_at(surface: Factory) -> None:
    # Without a resistance the torque grows evenly: each period has the same swing, two have twice that.
    drive = surface(resistance=0.0)
    ratios = (0.5, 0.7, 0.3)
    assert swing_of(drive, ratios, 5) == pytest.approx(swing_of(drive, ratios), rel=1e-9)


def test_equal_duty_ratios_and_blocked_legs_make_no_torque(surface: Factory) -> None:
    assert swing_of(surface(), (0.4, 0.4, 0.4)) == 0.0
    assert swing_of(surface(), (0.5, 0.7, 0.3), mode=LEG_OFF) == 0.0
