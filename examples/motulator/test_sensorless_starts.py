"""From which angles of the rotor motulator's sensorless controllers start."""

from __future__ import annotations

import pytest
from examples.motulator.starts import STARTS, start

FLUX, INJECTION = (candidate for candidate, _, _ in STARTS)


@pytest.mark.parametrize(("angle_deg", "starts"), [(0.0, True), (270.0, True), (90.0, False), (180.0, False)])
def test_flux_vector_control_starts_from_two_angles_and_stands_still_from_two(
    angle_deg: float, starts: bool
) -> None:
    """An observer alone is no start: from some angles the estimate never leaves standstill."""
    found = start(FLUX, 260.0, angle_deg)
    assert found.speed_rpm == pytest.approx(260.0 if starts else 0.0, abs=8.0), found


def test_signal_injection_needs_the_polarity_of_the_magnet() -> None:
    """Half a turn off it takes the magnet's other end for the pole, and runs away backward."""
    right, wrong = (start(INJECTION, 130.0, angle) for angle in (0.0, 180.0))
    assert right.speed_rpm == pytest.approx(130.0, abs=5.0), right
    assert wrong.speed_rpm < -1000.0, wrong
    assert wrong.back_deg > 10.0 * 360.0, wrong
