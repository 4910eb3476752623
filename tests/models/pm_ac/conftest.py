"""What the tests of the PM AC drive share: the surface and the interior machine, and drives that differ from them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from drivegate_models.pm_ac.plant.drive import PmAcDrive, make_pm_ac_drive

INTERIOR: dict[str, Any] = {
    "pole_pairs": 2,
    "resistance": 0.57,
    "direct_inductance": 8.72e-3,
    "quadrature_inductance": 22.78e-3,
    "magnet_flux": 0.0879,
    "link_voltage": 70.7 * 3**0.5,
    "current_limit": 7.07,
    "inertia": 0.002,
}
"""The machine of the literature on wide-speed operation (Morimoto, Sanada, Takeda 1994), in peak quantities."""
SURFACE: dict[str, Any] = {
    "pole_pairs": 11,
    "resistance": 0.08,
    "direct_inductance": 2.88e-3,
    "quadrature_inductance": 2.88e-3,
    "magnet_flux": 0.0308,
    "link_voltage": 96.0,
    "current_limit": 26.0,
    "inertia": 0.05,
}
"""Three sinusoidal phases of the paper's iron and copper."""


def _interior(**changes: Any) -> PmAcDrive:
    return make_pm_ac_drive(**(INTERIOR | changes))


def _surface(**changes: Any) -> PmAcDrive:
    return make_pm_ac_drive(**(SURFACE | changes))


@pytest.fixture(scope="session")
def interior() -> Callable[..., PmAcDrive]:
    """Return the factory of interior machines; keywords are those of `make_pm_ac_drive`."""
    return _interior


@pytest.fixture(scope="session")
def surface() -> Callable[..., PmAcDrive]:
    """Return the factory of surface machines; keywords are those of `make_pm_ac_drive`."""
    return _surface
