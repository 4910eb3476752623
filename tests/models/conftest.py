"""What the tests of the plant share: the reference motor, and drives that differ from it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from drivegate_models.half_bridge.plant.drive import Drive, make_drive
from drivegate_models.machine.emf import trapezoid_corners


def _motor(*, flat_deg: float = 98.0, window_deg: float = 144.0, **changes: Any) -> Drive:
    """Return the calibrated 5-phase machine without core loss, with some of its constants changed."""
    angles, values = trapezoid_corners(np.radians(flat_deg))
    constants: dict[str, Any] = {
        "phases": 5,
        "pole_pairs": 11,
        "resistance": 0.08,
        "inductance": 2.88e-3,
        "emf_constant": 0.339,
        "emf_angles": angles,
        "emf_values": values,
        "half_supply_voltage": 48.0,
        "hysteresis_band": 0.25,
        "window": np.radians(window_deg),
        "current_limit": 26.0,
        "inertia": 0.05,
    }
    return make_drive(**(constants | changes))


@pytest.fixture(scope="session")
def motor() -> Callable[..., Drive]:
    """Return the factory of drives; keywords are those of `make_drive`, `flat_deg` and `window_deg`."""
    return _motor


@pytest.fixture(scope="session")
def rpm() -> Callable[[float], float]:
    """Return the conversion from revolutions a minute to rad/s."""
    return lambda speed: speed * np.pi / 30.0
