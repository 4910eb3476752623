"""Energy closes for any machine and any command, and nothing dissipates less than nothing."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.models.drawn_runs import (
    GRAZED,
    UNDERFLOW,
    Run,
    account_of,
    check_energy,
    drawn,
    grazing,
    numbers,
    reference_machine,
    runs,
)

from drivegate_models.half_bridge.plant.drive import make_drive
from drivegate_models.half_bridge.plant.phases import advance_phases, make_phases
from drivegate_models.machine import ledger

RUNS = runs(
    make_drive,
    phases=st.integers(1, 9),
    flats=[98.0],
    windows=[144.0],
    to_window_edges=True,
)


def _grazing(band: float, reference: float, window_deg: float, resistance: float) -> Run:
    drive = make_drive(
        **reference_machine(98.0),
        phases=5,
        resistance=resistance,
        inductance=2.88e-3,
        hysteresis_band=band,
        window=math.radians(window_deg),
        current_limit=26.0,
    )
    return grazing(drive, reference, 5e-4, to_window_edge=True)


GRAZING = [
    _grazing(band, reference, window_deg, resistance)
    for band, reference in GRAZED
    for window_deg in (144.0, 180.0)
    for resistance in (0.0, 0.08)
]


def _check(run: Run) -> None:
    account = account_of(run, make_phases, advance_phases)
    check_energy(run, account)
    totals = account.totals
    assert totals[ledger.RETURNED] <= totals[ledger.EXCHANGED] * (1.0 + 1e-12) + UNDERFLOW, (
        "more comes back than was exchanged"
    )


@pytest.mark.kernel
@drawn(250)
@given(RUNS)
def test_energy_closes_for_drawn_machines(run: Run) -> None:
    _check(run)


@pytest.mark.kernel
@pytest.mark.parametrize("run", GRAZING)
def test_energy_closes_where_events_coincide(run: Run) -> None:
    _check(run)


@pytest.mark.kernel
@drawn(250)
@given(RUNS, numbers(0.0, 0.999))
def test_blocked_currents_decay_and_never_reverse(run: Run, share: float) -> None:
    """With the gates blocked and the back-EMF below the rails, a diode can only let a current die."""
    drive = run.drive
    phases = make_phases(drive)
    phases.currents[:] = run.currents
    totals = np.zeros(ledger.ENTRIES)
    angle = run.angle
    for period in run.periods:
        before = phases.currents.copy()
        rail = min(period.upper, period.lower) + drive.diode_drop
        speed = share * min(period.speed, rail / drive.emf_constant)
        advance_phases(
            drive,
            phases,
            angle,
            speed,
            period.upper,
            period.lower,
            0.0,
            period.advance,
            period.duration,
            totals,
        )
        angle += drive.pole_pairs * speed * period.duration
        after = phases.currents
        assert np.all(np.abs(after) <= np.abs(before)), f"a current grew from {before} to {after}"
        assert np.all(before * after >= 0.0), f"a current reversed from {before} to {after}"
    assert totals[ledger.SWITCHING] == 0.0, "blocked gates cannot switch"


@pytest.mark.nightly
@pytest.mark.kernel
@drawn(250)
@given(RUNS)
def test_the_current_stays_inside_the_band_while_the_rail_can_turn_it(run: Run) -> None:
    """Where a regulator that starts from rest has control throughout, no current passes i* + h."""
    drive = run.drive
    phases = make_phases(drive)
    totals = np.zeros(ledger.ENTRIES)
    angle = run.angle
    reference = max((period.reference for period in run.periods), default=0.0)
    for period in run.periods:
        speed = min(period.speed, 0.9 * min(period.upper, period.lower) / drive.emf_constant)
        advance_phases(
            drive,
            phases,
            angle,
            speed,
            period.upper,
            period.lower,
            reference,
            period.advance,
            period.duration,
            totals,
        )
        angle += drive.pole_pairs * speed * period.duration
    highest = reference + drive.hysteresis_band if reference > 0.0 else 0.0
    assert totals[ledger.PEAK] <= highest * (1.0 + 1e-12), (
        f"a current reached {totals[ledger.PEAK]!r} A; the band ends at {highest!r} A"
    )
