"""Currents that pass zero behind ideal switches: periods go at once, and magnitudes are divided where the zero is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.models.pm_ac.conftest import INTERIOR, SURFACE
from tests.models.pm_ac.plant.drawn_periods import DrawnRun
from tests.models.pm_ac.plant.test_quiet import AGREEMENT, advanced, difference
from tests.models.pm_ac.plant.test_quiet_period import whole

from drivegate_models.contract.duty.signals import LEG_OFF, LEG_PWM
from drivegate_models.machine import ledger
from drivegate_models.pm_ac.plant.advance import PmAcPhases
from drivegate_models.pm_ac.plant.drive import CENTRED, FALLING, RISING, Modulator, make_pm_ac_drive
from drivegate_models.pm_ac.plant.phase_segments import current_at

RUNS = 400


def crossing_run(seed: int, **changes: object) -> DrawnRun:
    """Draw a period in which a phase current is small, of one or more pulses of the legs."""
    draw = np.random.default_rng(seed)
    drive = make_pm_ac_drive(**((SURFACE if seed % 2 else INTERIOR) | changes))
    currents = draw.uniform(-0.5, 0.5, 2) * drive.current_limit
    zero = 0.5 * np.pi - np.angle(complex(*currents)) + draw.integers(6) * np.pi / 3.0
    return DrawnRun(
        drive,
        (float(currents[0]), float(currents[1])),
        float(zero + draw.uniform(-0.05, 0.05)),
        draw.uniform(-60.0, 60.0),
        drive.link_voltage,
        1e-4,
        (tuple(draw.uniform(0.3, 0.7, 3)),),
        ((LEG_PWM, LEG_PWM, LEG_PWM),),
        (int(draw.choice((CENTRED, RISING, FALLING))),),
    )


def crossings(phases: PmAcPhases, segments: int) -> int:
    """Count the changes of a current's sign from end to end of the segments of a period that went at once."""
    currents = [[current_at(phases.rows, n, leg) for n in range(segments + 1)] for leg in range(3)]
    return int(np.count_nonzero(np.diff(np.sign(currents), axis=1)))


def test_periods_with_zeros_agree_with_the_series() -> None:
    counts = []
    for run in map(crossing_run, range(RUNS)):
        (phases, totals), (other, _) = advanced(run, False), advanced(run, True)
        assert difference(run)[0] <= AGREEMENT
        scale = float(np.sum(other.magnitudes))
        assert np.max(np.abs(phases.magnitudes - other.magnitudes)) <= AGREEMENT * scale
        counts.append(crossings(phases, int(totals[ledger.EVENTS])) if whole(phases) else 0)
    assert np.count_nonzero(counts) >= RUNS // 4, "few of the periods with a zero go at once"
    assert max(counts) >= 3, "no current passes zero more than once"


@pytest.mark.parametrize(
    "changes",
    [
        {"switch_drop": 0.5},
        {"diode_drop": 0.5},
        {"turn_on_energy": 1e-4},
        {"turn_off_energy": 1e-4},
        {"modulator": Modulator(dead_time=1e-6)},
    ],
)
def test_a_zero_that_changes_a_voltage_or_a_loss_is_left_to_the_segments(changes: dict[str, object]) -> None:
    changed = 0
    for seed in range(RUNS // 10):
        run = crossing_run(seed, **changes)
        phases, totals = advanced(run, False)
        assert difference(run)[0] <= AGREEMENT
        if whole(phases):
            assert crossings(phases, int(totals[ledger.EVENTS])) == 0
        changed += whole(advanced(crossing_run(seed), False)[0]) and not whole(phases)
    assert changed >= RUNS // 40, "few of the periods have a zero"


@pytest.mark.kernel
def test_the_current_of_a_blocked_leg_is_left_to_the_segments() -> None:
    """It stays at zero when it has come there."""
    for seed in range(20):
        for leg in range(3):
            modes = tuple(LEG_OFF if n == leg else LEG_PWM for n in range(3))
            run = replace(crossing_run(seed), modes=(modes,))
            assert difference(run)[0] <= AGREEMENT


@pytest.mark.kernel
def test_a_current_that_turns_near_zero_is_left_to_the_segments() -> None:
    """With all legs alike and without resistance the flux stands still, and the first phase's current comes back."""
    run = crossing_run(1, resistance=0.0)
    drive, speed = run.drive, 30.0
    half = 0.5 * drive.pole_pairs * speed * run.duration
    for least in (-1e-5, 0.0, 1e-5):
        flux = drive.magnet_flux - drive.direct_inductance * least
        currents = (flux * np.exp(1j * half) - drive.magnet_flux) / drive.direct_inductance
        turned = replace(
            run,
            angle=-half,
            speed=speed,
            currents=(float(currents.real), float(currents.imag)),
            ratios=((0.0, 0.0, 0.0),),
            alignments=(CENTRED,),
        )
        phases, _ = advanced(turned, False)
        assert not whole(phases)
        assert difference(turned)[0] <= AGREEMENT
