"""Quiet segments give what the power series give, and are left to them where a current may come to an event."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.models.pm_ac.conftest import SURFACE
from tests.models.pm_ac.plant.drawn_periods import DrawnRun, drawn_run

from drivegate_models.contract.duty.signals import LEG_PWM
from drivegate_models.machine import ledger
from drivegate_models.machine.advance_status import COMPLETED
from drivegate_models.pm_ac.plant.advance import PmAcPhases, advance_period, make_phases
from drivegate_models.pm_ac.plant.drive import CENTRED, make_pm_ac_drive

AGREEMENT = 1e-11
"""Greatest difference, relative to the scale of each quantity."""


def advanced(run: DrawnRun, follows_torque: bool) -> tuple[PmAcPhases, np.ndarray]:
    """Advance a run by its first period; where the torque is followed no segment is quiet."""
    phases, totals = make_phases(follows_torque=follows_torque), np.zeros(ledger.ENTRIES)
    phases.rotor_currents[:] = run.currents
    status = advance_period(
        run.drive,
        phases,
        run.angle,
        run.speed,
        run.link,
        np.array(run.ratios[0]),
        np.array(run.modes[0], np.int64),
        run.alignments[0],
        run.duration,
        totals,
    )
    assert status == COMPLETED
    return phases, totals


def difference(run: DrawnRun) -> tuple[float, bool]:
    """Return how far both ways are apart, and whether they are two."""
    drive = run.drive
    (phases, totals), (other, expected) = advanced(run, False), advanced(run, True)
    current = float(np.hypot(*run.currents)) + expected[ledger.PEAK] + 1e-90
    reach = drive.quadrature_inductance + drive.direct_inductance
    energy = 1e-200 + drive.resistance * current**2 * run.duration + reach * current**2
    energy += expected[ledger.EXCHANGED] + expected[ledger.DEVICE]
    scales = {
        ledger.MAGNITUDE: current * run.duration,
        ledger.SQUARE: current**2 * run.duration,
        ledger.IMPULSE: 3.0
        * drive.pole_pairs
        * (drive.magnet_flux + reach * current)
        * current
        * run.duration,
        ledger.UPPER: energy,
        ledger.EXCHANGED: energy,
        ledger.RETURNED: energy,
        ledger.DEVICE: energy,
        ledger.PEAK: current,
    }
    apart = [float(np.max(np.abs(phases.currents - other.currents))) / current]
    apart += [float(abs(totals[entry] - expected[entry])) / scale for entry, scale in scales.items()]
    return max(apart), not np.array_equal(totals, expected)


def test_both_ways_agree_for_drawn_periods() -> None:
    found = {seed: difference(drawn_run(seed)) for seed in range(1500)}
    worst = max(found, key=lambda seed: found[seed][0])
    assert found[worst][0] <= AGREEMENT, f"run {worst} differs by {found[worst][0]:.1e} of a scale"
    quiet = sum(differs for _, differs in found.values())
    assert quiet > 300, f"only {quiet} of {len(found)} runs have a quiet segment"


@pytest.mark.kernel
@pytest.mark.parametrize("speed", [0.0, 1.0, -3.0])
@pytest.mark.parametrize("current", [0.0, 1e-9, 1.0])
def test_currents_at_zero_are_left_to_the_series(current: float, speed: float) -> None:
    """A phase current that begins at zero, crosses it or is greatest within a segment."""
    for seed in range(8):
        run = drawn_run(seed)
        base = abs(run.speed) or 10.0
        run = replace(run, speed=speed * base, currents=(0.0, current * run.drive.current_limit))
        apart, _ = difference(run)
        assert apart <= AGREEMENT, f"run {seed} differs by {apart:.1e} of a scale"


@pytest.mark.kernel
def test_a_current_that_is_greatest_within_a_segment_is_left_to_the_series() -> None:
    """With all legs alike the flux stands still; the first phase has its greatest current as the rotor passes it."""
    drive = make_pm_ac_drive(**(SURFACE | {"resistance": 0.0}))
    speed, period, greatest = 30.0, 1e-4, 2.0
    half = 0.5 * drive.pole_pairs * speed * period
    flux = drive.magnet_flux - drive.direct_inductance * greatest
    currents = (flux * np.exp(1j * half) - drive.magnet_flux) / drive.direct_inductance
    run = DrawnRun(
        drive,
        (float(currents.real), float(currents.imag)),
        -half,
        speed,
        drive.link_voltage,
        period,
        ((0.0, 0.0, 0.0),),
        ((LEG_PWM, LEG_PWM, LEG_PWM),),
        (CENTRED,),
    )
    (phases, totals), (_, expected) = advanced(run, False), advanced(run, True)
    assert np.max(np.abs(phases.currents)) < greatest - 1e-4, "the greatest current lies within"
    assert expected[ledger.PEAK] == pytest.approx(greatest, rel=1e-12)
    assert totals[ledger.PEAK] == pytest.approx(greatest, rel=1e-12)
