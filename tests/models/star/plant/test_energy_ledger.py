"""Energy and charge close for any star and any command, and no event is awaited for ever."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.models.drawn_runs import (
    CLOSURE,
    GRAZED,
    Period,
    Run,
    account_of,
    check_energy,
    drawn,
    grazing,
    reference_machine,
    runs,
)

from drivegate_models.machine import ledger
from drivegate_models.machine.advance_status import TOO_MANY_EVENTS
from drivegate_models.star.plant.drive import EVERY_HALF, ON_PWM, PWM_ON, UPPER_ONLY, make_star_drive
from drivegate_models.star.plant.phases import advance_phases, make_phases

NEUTRAL = 1e-12
"""Greatest sum of the phase currents, over their magnitudes."""
REFERENCE = reference_machine(120.0) | {
    "phases": 3,
    "resistance": 0.048,
    "inductance": 1.728e-3,
    "current_limit": 130.0 / 3.0,
}


def _balanced(run: Run) -> Run:
    """Return a run whose first currents sum to zero."""
    mean = sum(run.currents) / len(run.currents)
    balanced = [value - mean for value in run.currents[1:]]
    return replace(run, currents=(-math.fsum(balanced), *balanced))


RUNS = runs(
    make_star_drive,
    phases=st.sampled_from([3, 3, 3, 5, 7, 9]),
    flats=[60.0, 120.0, 150.0],
    windows=[60.0, 120.0, 150.0],
    references=[1e-9],
    advances=[math.pi / 6.0],
    further={"regulation": st.sampled_from([EVERY_HALF, EVERY_HALF, UPPER_ONLY, PWM_ON, ON_PWM])},
).map(_balanced)


def _grazing(band: float, reference: float, window_deg: float, resistance: float, regulation: int) -> Run:
    drive = make_star_drive(
        **REFERENCE
        | {
            "hysteresis_band": band,
            "window": math.radians(window_deg),
            "resistance": resistance,
            "regulation": regulation,
        }
    )
    return grazing(drive, reference, None, to_window_edge=False)


GRAZING = [
    _grazing(band, reference, window_deg, resistance, regulation)
    for band, reference in GRAZED
    for window_deg in (60.0, 120.0, 180.0)
    for resistance in (0.0, 0.048)
    for regulation in (EVERY_HALF, UPPER_ONLY, PWM_ON)
]


def check(run: Run) -> None:
    account = account_of(run, make_phases, advance_phases)
    check_energy(run, account)
    charge = account.share(account.totals[ledger.UPPER] - account.totals[ledger.LOWER])
    assert charge <= CLOSURE, f"the halves differ by {charge:.1e}"
    for currents in account.currents:
        size = float(np.sum(np.abs(currents)))
        assert abs(math.fsum(currents)) <= NEUTRAL * size, f"currents of a star sum to zero, not {currents}"


@pytest.mark.kernel
@drawn(300)
@given(RUNS)
def test_energy_and_charge_close_for_drawn_stars(run: Run) -> None:
    check(run)


@pytest.mark.kernel
@pytest.mark.parametrize("run", GRAZING)
def test_energy_closes_where_events_coincide(run: Run) -> None:
    check(run)


@pytest.mark.kernel
@pytest.mark.parametrize("regulation", [EVERY_HALF, UPPER_ONLY, PWM_ON, ON_PWM])
def test_rounding_at_a_tiny_reference_costs_no_energy(regulation: int) -> None:
    """A snapping distance in amperes would swallow such currents whole."""
    drive = make_star_drive(
        **REFERENCE, window=math.radians(120.0), hysteresis_band=0.0, regulation=regulation
    )
    periods = tuple(Period(60.0, 3e-9, 0.3, 48.0, 48.0, 5e-4) for _ in range(40))
    check(Run(drive, 0.0, (0.0,) * 3, periods))


@pytest.mark.kernel
def test_what_rounding_leaves_of_a_current_is_not_passed_to_and_fro() -> None:
    drive = make_star_drive(
        **REFERENCE
        | {
            "phases": 9,
            "pole_pairs": 1,
            "emf_constant": 0.96,
            "emf_angles": np.array([0.0, 0.5 * math.pi]),
            "emf_values": np.array([0.0, 1.0]),
            "resistance": 0.31817142857142855,
            "inductance": 5.4857142857142857e-05,
            "window": math.radians(144.0),
            "hysteresis_band": 0.0,
            "diode_drop": 2.0,
        }
    )
    still = Period(0.0, 163.0, 1.5, 48.0, 48.0, 5e-4)
    periods = (still, replace(still, reference=1.2063561186383354e-08, advance=0.0))
    check(_balanced(Run(drive, 0.0, (0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0), periods)))


def test_a_band_that_no_current_can_rest_in_is_given_up() -> None:
    drive = make_star_drive(**REFERENCE, window=math.radians(120.0), hysteresis_band=1e-10)
    totals = np.zeros(ledger.ENTRIES)
    status = advance_phases(drive, make_phases(drive), 0.0, 50.0, 48.0, 48.0, 20.0, 0.0, 5e-3, totals)
    assert status == TOO_MANY_EVENTS
