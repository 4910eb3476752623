"""What belongs to the rotor frame and what to the phases are the same currents."""

import numpy as np
import pytest

from drivegate_models.machine.rotor_frame import phase_currents


@pytest.mark.kernel
def test_phase_currents_are_those_of_the_rotor_frame_seen_from_the_phases_axes() -> None:
    angles = np.linspace(-7.0, 9.0, 50)
    direct, quadrature = np.sin(angles), np.cos(2.0 * angles)
    axes = [angles - number * 2.0 * np.pi / 3.0 for number in range(3)]
    expected = np.column_stack([direct * np.cos(axis) - quadrature * np.sin(axis) for axis in axes])
    np.testing.assert_allclose(phase_currents(direct, quadrature, angles), expected, rtol=0.0, atol=1e-14)
