"""Whole quiet periods: how many of those drawn are, what is left to the segments, and the maps between segments."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.models.pm_ac.conftest import SURFACE
from tests.models.pm_ac.plant.drawn_periods import DrawnRun, drawn_run
from tests.models.pm_ac.plant.test_quiet import AGREEMENT, advanced, difference

from drivegate_models.contract.duty.signals import LEG_PWM
from drivegate_models.machine import ledger
from drivegate_models.pm_ac.plant.advance import PmAcPhases
from drivegate_models.pm_ac.plant.drive import CENTRED, Modulator, make_pm_ac_drive
from drivegate_models.pm_ac.plant.rows import SQUARE, TIME

CURRENTS = (-1.0, 3.0)
"""Along and across the magnet's axis at the start of the chosen periods (A)."""


def whole(phases: PmAcPhases) -> bool:
    """Tell whether a period that begins with a current has been passed at once: then its first square is known."""
    return bool(phases.rows[SQUARE] > 0.0)


def chosen(dead_time: float = 0.0, angle: float = 0.6, **changes: float) -> DrawnRun:
    """Return a period of three centred pulses; at the angle given here no phase is near zero."""
    drive = make_pm_ac_drive(modulator=Modulator(dead_time=dead_time), **(SURFACE | changes))
    return DrawnRun(
        drive,
        CURRENTS,
        angle,
        60.0,
        drive.link_voltage,
        1e-4,
        ((0.7, 0.5, 0.35),),
        ((LEG_PWM, LEG_PWM, LEG_PWM),),
        (CENTRED,),
    )


def test_drawn_periods_that_are_passed_at_once_agree_with_the_series() -> None:
    runs = [replace(run, duration=0.1 * run.duration) for run in map(drawn_run, range(600))]
    passed = [run for run in runs if whole(advanced(run, False)[0])]
    assert len(passed) > 60, f"only {len(passed)} of {len(runs)} periods are quiet"
    worst = max(difference(run)[0] for run in passed)
    assert worst <= AGREEMENT, f"a period differs by {worst:.1e} of a scale"


@pytest.mark.kernel
@pytest.mark.parametrize("drop", [0.0, 0.8])
@pytest.mark.parametrize("dead_time", [0.0, 2e-6])
def test_a_period_of_seven_segments_is_passed_at_once(dead_time: float, drop: float) -> None:
    run = chosen(dead_time, switch_drop=drop, diode_drop=0.7 * drop)
    phases, totals = advanced(run, False)
    assert whole(phases)
    assert totals[ledger.EVENTS] == 7
    assert phases.rows[TIME + 7] == run.duration
    assert difference(run)[0] <= AGREEMENT
    assert totals[ledger.DEVICE] > 0.0 if drop > 0.0 else totals[ledger.DEVICE] == 0.0


@pytest.mark.kernel
def test_a_current_that_comes_to_zero_is_left_to_the_segments_where_that_changes_a_voltage() -> None:
    crossing = np.arctan2(CURRENTS[0], CURRENTS[1])
    for dead_time in (0.0, 2e-6):
        run = chosen(dead_time, angle=float(crossing))
        phases, _ = advanced(run, False)
        assert whole(phases) == (dead_time == 0.0)
        assert difference(run)[0] <= AGREEMENT


@pytest.mark.kernel
def test_a_current_that_is_greatest_within_a_segment_is_found_where_all_else_is_passed_at_once() -> None:
    """With all legs alike the first phase has its greatest current as the rotor passes it."""
    run = replace(chosen(resistance=0.0), ratios=((0.0, 0.0, 0.0),), speed=30.0)
    greatest, half = 2.0, 0.5 * run.drive.pole_pairs * 30.0 * run.duration
    flux = run.drive.magnet_flux - run.drive.direct_inductance * greatest
    currents = (flux * np.exp(1j * half) - run.drive.magnet_flux) / run.drive.direct_inductance
    run = replace(run, angle=-half, currents=(float(currents.real), float(currents.imag)))
    phases, totals = advanced(run, False)
    assert whole(phases)
    assert np.max(np.abs(phases.currents)) < greatest - 1e-4, "the greatest current lies within"
    assert totals[ledger.PEAK] == pytest.approx(greatest, rel=1e-12)
