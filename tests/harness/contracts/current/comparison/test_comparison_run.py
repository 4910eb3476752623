"""What a run of a comparison is measured as, on signals made up for it."""

import numpy as np
import pytest

from drivegate.contracts.current.comparison.measuring import converged_after, recovery_figures
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.limits import limits_of

LIMITS = limits_of(load_drive("paper-5-phase"))
TIMES = np.arange(0.0, 20.0, 0.01)


def columns(error, advance=30.0):
    return {
        "time_s": TIMES,
        "speed_reference_rpm": np.full(TIMES.shape, 1500.0),
        "speed_rpm": 1500.0 + error(TIMES),
        "advance_deg": np.broadcast_to(advance, TIMES.shape),
    }


def dying_out(times):
    return np.where(times < 10.0, 0.0, -40.0 * np.exp(-(times - 10.0) / 0.5))


def test_recovery_is_timed_to_the_last_crossing():
    figures = recovery_figures(columns(dying_out), 10.0, 10.0, LIMITS)
    assert figures["worst_error_rpm"] == pytest.approx(40.0)
    assert figures["recovery_s"] == pytest.approx(0.5 * np.log(8.0), abs=0.011)
    assert figures["held_before"] is True


def test_a_disturbance_that_is_never_felt_takes_no_time():
    figures = recovery_figures(columns(np.zeros_like), 10.0, 10.0, LIMITS)
    assert figures == {"held_before": True, "worst_error_rpm": 0.0, "recovery_s": 0.0}


def test_what_is_not_held_again_is_reported():
    figures = recovery_figures(columns(lambda times: np.where(times < 10.0, 0.0, -200.0)), 10.0, 10.0, LIMITS)
    assert figures["recovery_s"] is None
    lost = recovery_figures(columns(lambda times: np.full_like(times, -30.0)), 10.0, 10.0, LIMITS)
    assert lost["held_before"] is False


def test_convergence_waits_for_the_angle():
    falling = np.where(TIMES < 4.0, 50.0 - 5.0 * TIMES, 30.0)
    after = converged_after(columns(np.zeros_like, falling), {"advance_deg": 30.0}, LIMITS)
    assert after == pytest.approx(3.81, abs=0.011), "at 3.8 s the angle comes within 1°"


def test_convergence_waits_for_the_speed():
    figures = {"advance_deg": 30.0}
    assert converged_after(
        columns(lambda times: np.where(times < 7.0, 6.0, 0.0)), figures, LIMITS
    ) == pytest.approx(7.0)
    assert converged_after(columns(lambda times: np.full_like(times, 6.0)), figures, LIMITS) is None
