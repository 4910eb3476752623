"""The calibrated motor against the published operating points, on the ideal regulator without core loss."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

from drivegate_models.half_bridge.plant.drive import Drive
from drivegate_models.machine.period import PERIODIC
from drivegate_models.steady.steady_state import SteadyState, steady_state

LIMIT = 26.0
HALF_SUPPLY = 48.0

At = Callable[..., SteadyState]


@pytest.fixture(scope="module")
def at(motor: Callable[..., Drive], rpm: Callable[[float], float]) -> At:
    """Return the steady state as a function of rpm, degrees and amperes."""
    drive = motor(hysteresis_band=0.0)

    def solved(speed: float, advance_deg: float, reference: float = LIMIT) -> SteadyState:
        return steady_state(drive, rpm(speed), reference, np.radians(advance_deg))

    return solved


def _at_torque(at: At, speed: float, advance_deg: float, torque: float) -> SteadyState:
    """Return the steady state with the least current reference that gives a torque."""
    references = np.linspace(0.5, LIMIT, 52)
    above = next(
        k for k, reference in enumerate(references) if at(speed, advance_deg, reference).torque >= torque
    )
    reference = brentq(
        lambda value: at(speed, advance_deg, value).torque - torque,
        references[above - 1],
        references[above],
        xtol=1e-10,
    )
    return at(speed, advance_deg, reference)


def _ripple_percent(state: SteadyState) -> float:
    return 100.0 * (state.torque_highest - state.torque_lowest) / state.torque


@pytest.mark.parametrize(
    ("speed", "torque", "low", "high", "edge"), [(1500, 9.8, 45, 60, 51.9), (1200, 11.88, 30, 50, 39.9)]
)
def test_least_advance_that_reaches_the_published_torque(
    at: At, speed: float, torque: float, low: float, high: float, edge: float
) -> None:
    """Published: 52 degrees are necessary at 1500 rpm (Fig. 6), 40 degrees serve at 1200 rpm (Fig. 9)."""
    found = brentq(lambda angle: at(speed, angle).torque - torque, low, high, xtol=1e-6)
    assert found == pytest.approx(edge, abs=0.05), f"the edge at {speed} rpm lies at {found:.3f} deg"


@pytest.mark.parametrize(
    ("speed", "edge"), [(550, 26), (700, 33), (1000, 33), (1200, 40), (1400, 48), (1500, 51), (2000, 58)]
)
def test_least_advance_that_reaches_the_rated_power(
    at: At, rpm: Callable[[float], float], speed: float, edge: float
) -> None:
    angles = np.arange(0.0, 80.0, 0.5)
    powers = [rpm(speed) * at(speed, angle).torque for angle in angles]
    first = int(np.argmax(np.array(powers) >= 1500.0))
    found = brentq(
        lambda angle: rpm(speed) * at(speed, angle).torque - 1500.0, angles[first - 1], angles[first]
    )
    assert found == pytest.approx(edge, abs=1.0), f"1.5 kW at {speed} rpm need {found:.2f} deg"


def test_greatest_power_at_base_speed(at: At, rpm: Callable[[float], float]) -> None:
    """Table 1 rates the drive at 1.5 kW at 500 rpm and 26 A."""
    best = minimize_scalar(lambda angle: -at(500, angle).torque, bounds=(20, 50), method="bounded")
    assert -rpm(500) * best.fun == pytest.approx(1504.0, abs=1.0)
    assert rpm(500) * at(500, 33).torque == pytest.approx(1504.0, abs=1.0)
    assert best.x == pytest.approx(33.0, abs=0.7), f"the greatest power lies at {best.x:.2f} deg"
    assert at(500, 0).torque == pytest.approx(19.0, abs=0.5), "without advance rated torque is out of reach"


def test_worst_ripple(at: At) -> None:
    """Published: below 13 % at 1500 rpm (Fig. 6)."""
    ripple = _ripple_percent(_at_torque(at, 1500, 52.5, 9.8))
    assert 11.95 <= ripple <= 12.25, f"the ripple at 52.5 deg is {ripple:.2f} %"


@pytest.mark.parametrize("speed", [600, 1000, 1500, 2000])
def test_torque_keeps_its_sign_under_phase_advance(
    at: At, rpm: Callable[[float], float], speed: float
) -> None:
    """Published of conventional drives with phase advance: ripple of 125 % and more, torque that changes sign."""
    state = _at_torque(at, speed, 33.0 + 0.025 * (speed - 500.0), 1500.0 / rpm(speed))
    assert state.torque_lowest > 0.0, f"the torque falls to {state.torque_lowest:.2f} N·m"
    assert _ripple_percent(state) < 25.0, f"the ripple is {_ripple_percent(state):.1f} %"


def test_the_search_lowers_the_current_sum(at: At, rpm: Callable[[float], float]) -> None:
    """From the initial angle of 58 degrees to 52.5 degrees the currents fall much, the watts hardly."""
    initial, optimal = _at_torque(at, 1500, 58, 9.8), _at_torque(at, 1500, 52.5, 9.8)
    assert initial.certified == optimal.certified == PERIODIC
    assert initial.current_sum == pytest.approx(44.4, abs=0.05)
    assert optimal.current_sum == pytest.approx(40.6, abs=0.05)
    assert optimal.exchanged_power == pytest.approx(HALF_SUPPLY * optimal.current_sum, rel=1e-12)
    assert optimal.exchanged_power == pytest.approx(1949.0, abs=1.0)
    assert optimal.source_power == pytest.approx(1571.0, abs=1.0)
    assert optimal.source_power / initial.source_power - 1.0 == pytest.approx(-0.004, abs=0.001)
    assert optimal.source_power == pytest.approx(rpm(1500) * optimal.torque + optimal.copper_loss, rel=1e-10)
