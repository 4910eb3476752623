"""The greatest current within a segment: found by interpolation, as the series of the segment have it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pytest
from tests.models.pm_ac.conftest import INTERIOR, SURFACE
from tests.models.pm_ac.plant.drawn_periods import DrawnRun
from tests.models.pm_ac.plant.test_quiet import AGREEMENT, advanced, difference
from tests.models.pm_ac.plant.test_quiet_period import whole

from drivegate_models.contract.duty.signals import LEG_PWM
from drivegate_models.machine import ledger
from drivegate_models.pm_ac.plant.circuit import Circuit, circuit_of
from drivegate_models.pm_ac.plant.drive import CENTRED, FALLING, RISING, make_pm_ac_drive
from drivegate_models.pm_ac.plant.interpolation import interpolant_of, interpolated, interpolated_slope
from drivegate_models.pm_ac.plant.jets import Jet, Rates, rates_of
from drivegate_models.pm_ac.plant.peaks import top_within
from drivegate_models.pm_ac.plant.phase_segments import current_at, frame_at, is_steep
from drivegate_models.pm_ac.plant.polynomial import extremes
from drivegate_models.pm_ac.plant.rows import ACROSS, ALONG, TIME
from drivegate_models.pm_ac.plant.series import free_series, make_series, phase_series

CLOSENESS = 1e-13
"""Of a greatest current, over the greatest one of the period."""
RUNS = 400


class Passed(NamedTuple):
    """A period that has been passed at once."""

    circuit: Circuit
    rates: Rates
    rows: np.ndarray
    segments: int


def steady_run(seed: int) -> DrawnRun:
    """Draw a period whose voltages match the back-EMF, or are none as the magnet passes a phase."""
    draw = np.random.default_rng(seed)
    is_driven = seed % 4 < 2
    drive = make_pm_ac_drive(
        **(SURFACE if seed % 2 else INTERIOR) | ({} if is_driven else {"resistance": 0.0})
    )
    speed, angle = draw.uniform(-60.0, 60.0), draw.uniform(0.0, 6.3)
    currents = draw.uniform(-0.5, 0.5, 2) * drive.current_limit
    turning = drive.pole_pairs * speed
    if not is_driven:
        angle = draw.integers(6) * np.pi / 3.0 - turning * draw.uniform(0.0, 1e-4)
    flux = (
        drive.direct_inductance * currents[0]
        + drive.magnet_flux
        + 1j * drive.quadrature_inductance * currents[1]
    )
    voltage = drive.resistance * (currents[0] + 1j * currents[1]) + 1j * turning * flux
    voltage *= np.exp(1j * (angle + 5e-5 * turning)) * (draw.uniform(0.5, 1.5) if is_driven else 0.0)
    legs = np.real(voltage * np.exp(-2j * np.pi / 3.0 * np.arange(3))) / drive.link_voltage
    return DrawnRun(
        drive,
        (float(currents[0]), float(currents[1])),
        angle,
        speed,
        drive.link_voltage,
        1e-4,
        (tuple(np.clip(0.5 + legs, 0.0, 1.0)),),
        ((LEG_PWM, LEG_PWM, LEG_PWM),),
        (int(draw.choice((CENTRED, RISING, FALLING))),),
    )


def passed(run: DrawnRun) -> Passed | None:
    """Advance a run by its period; return what is known of that if it has been passed at once."""
    phases, totals = advanced(run, False)
    if not whole(phases):
        return None
    circuit = circuit_of(run.drive, run.speed, run.link, *run.currents, run.duration)
    return Passed(circuit, rates_of(circuit), phases.rows, int(totals[ledger.EVENTS]))


def top_of_series(of: Passed, n: int, leg: int) -> float:
    """Return the greatest magnitude of a phase current in a segment, by its series (A)."""
    frame, series = frame_at(of.rows, n), make_series()
    length = of.rows[TIME + n + 1] - of.rows[TIME + n]
    along, across = of.rows[ALONG + n], of.rows[ACROSS + n]
    direct = frame.cosine * along + frame.sine * across
    quadrature = frame.cosine * across - frame.sine * along
    count = free_series(of.circuit, series, frame, direct, quadrature, length)
    phase_series(of.circuit, series, frame, leg, count, length)
    lowest, highest = extremes(series.other, count, series.slopes)
    return max(-lowest, highest)


def segments(runs: int) -> Iterator[tuple[Passed, int, int]]:
    """Give each phase in each segment of those of the drawn periods that are passed at once."""
    for period in map(passed, map(steady_run, range(runs))):
        if period is not None:
            yield from ((period, n, leg) for n in range(period.segments) for leg in range(3))


def test_currents_are_greatest_where_the_series_have_it() -> None:
    within = 0
    for period, n, leg in segments(RUNS):
        ends = max(abs(current_at(period.rows, n, leg)), abs(current_at(period.rows, n + 1, leg)))
        top = top_within(period.circuit, period.rates, make_series(), period.rows, n, leg)
        expected = top_of_series(period, n, leg)
        assert max(ends, top) == pytest.approx(expected, rel=CLOSENESS)
        within += expected > ends * (1.0 + 1e-9)
    assert within >= RUNS // 20, f"only {within} currents are greatest within a segment"


def test_the_peaks_of_drawn_periods_are_those_of_the_series() -> None:
    worst = max(difference(steady_run(seed))[0] for seed in range(RUNS))
    assert worst <= AGREEMENT, f"a period differs by {worst:.1e} of a scale"


@pytest.mark.kernel
def test_a_polynomial_of_degree_seven_is_its_own_interpolant() -> None:
    polynomial = np.polynomial.Polynomial([0.3, -2.0, 1.5, 4.0, -3.0, 0.7, -1.1, 0.9])
    length = 1.25

    def jet(time: float) -> Jet:
        return Jet(
            *(
                float(polynomial.deriv(order)(time)) if order else float(polynomial(time))
                for order in range(4)
            )
        )

    interpolant = interpolant_of(jet(0.0), jet(length), length)
    for share in (0.0, 0.2, 0.5, 0.9, 1.0):
        assert interpolated(interpolant, share) == pytest.approx(
            polynomial(share * length), rel=1e-13, abs=1e-13
        )


@pytest.mark.kernel
def test_a_slope_of_the_third_degree_is_interpolated_by_itself() -> None:
    polynomial = np.polynomial.Polynomial([0.3, -2.0, 1.5, 4.0, -3.0])
    length = 1.25
    begin, end = (
        Jet(0.0, float(polynomial.deriv(1)(time)), float(polynomial.deriv(2)(time)), 0.0)
        for time in (0.0, length)
    )
    for share in (0.0, 0.3, 1.0):
        slope = interpolated_slope(begin, end, length, share)
        assert slope == pytest.approx(float(polynomial.deriv(1)(share * length)), rel=1e-13)


@pytest.mark.kernel
@pytest.mark.parametrize(
    ("vertex", "expected"), [(-0.01, True), (0.01, False), (0.5, False), (0.99, False), (1.01, True)]
)
def test_a_current_is_steep_where_the_most_bent_one_does_not_turn(vertex: float, expected: bool) -> None:
    before, behind, deviation = 0.5 * vertex**2, 0.5 * (1.0 - vertex) ** 2, 0.125
    assert is_steep(before, behind, deviation) is expected
