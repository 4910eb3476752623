"""What the tests of the star share: the machine of the paper's iron and copper, and stars that differ from it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from drivegate_models.machine.emf import trapezoid_corners
from drivegate_models.star.plant.drive import StarDrive, make_star_drive


def _star(*, flat_deg: float = 120.0, window_deg: float = 120.0, **changes: Any) -> StarDrive:
    """Return the star of the same iron and copper as the 5-phase machine, with some of its constants changed."""
    angles, values = trapezoid_corners(np.radians(flat_deg))
    constants: dict[str, Any] = {
        "phases": 3,
        "pole_pairs": 11,
        "resistance": 0.048,
        "inductance": 1.728e-3,
        "emf_constant": 0.339,
        "emf_angles": angles,
        "emf_values": values,
        "half_supply_voltage": 48.0,
        "hysteresis_band": 0.0,
        "window": np.radians(window_deg),
        "current_limit": 43.3,
        "inertia": 0.05,
    }
    return make_star_drive(**(constants | changes))


@pytest.fixture(scope="session")
def star() -> Callable[..., StarDrive]:
    """Return the factory of stars; keywords are those of `make_star_drive`, `flat_deg` and `window_deg`."""
    return _star
