"""A period of a link with a capacitor that is passed at once, against the general advance that finds every event."""

from __future__ import annotations

import numpy as np
import pytest

from drivegate_models.contract.duty.signals import LEG_PWM
from drivegate_models.machine import ledger
from drivegate_models.machine.advance_status import COMPLETED
from drivegate_models.pm_ac.plant import dc_link
from drivegate_models.pm_ac.plant.advance import PmAcPhases, make_phases
from drivegate_models.pm_ac.plant.dc_link import BATTERY, RECTIFIER, DcLink, charge_link
from drivegate_models.pm_ac.plant.drive import Modulator, make_pm_ac_drive
from drivegate_models.pm_ac.plant.linked_advance import advance_linked_period
from drivegate_models.pm_ac.plant.rows import ENERGY, WIDTH

AGREEMENT = 1e-10
PERIOD = 5e-5
VOLT, LIMIT = 48.0, 12.0


def _was_passed_at_once(phases: PmAcPhases) -> bool:
    return bool(phases.rows[ENERGY : ENERGY + WIDTH].any())


def _advanced(seed: int, *, at_once: bool) -> tuple[bool, np.ndarray, np.ndarray]:
    """Advance a drawn drive by one period; return whether it was passed at once, its state, and both ledgers."""
    draw = np.random.default_rng(seed)
    ratio = float(draw.choice([1.0, 1.6, 4.0]))
    source = int(draw.choice([BATTERY, RECTIFIER]))
    chopper = float(draw.choice([0.0, 0.2]))
    drive = make_pm_ac_drive(
        pole_pairs=4,
        resistance=float(draw.uniform(0.0, 0.5)),
        magnet_flux=6e-3,
        direct_inductance=2e-4,
        quadrature_inductance=ratio * 2e-4,
        link_voltage=VOLT,
        current_limit=LIMIT,
        modulator=Modulator(dead_time=float(draw.choice([0.0, 2e-7]))),
        switch_drop=float(draw.choice([0.0, 0.9])),
        diode_drop=float(draw.choice([0.0, 0.7])),
        dc_link=DcLink(1e-3, 0.1, source, 60.0, 5.0, 9.0, 56.0, 54.0, chopper),
    )
    # An angle at which no current is near zero, and a torque of either sign.
    angle = float(draw.integers(0, 6)) * np.pi / 3.0 + float(draw.uniform(-0.1, 0.1)) + np.pi / 12.0
    size = float(draw.uniform(0.5, 1.0)) * LIMIT * float(draw.choice([-1.0, 1.0]))
    speed = float(draw.uniform(-1.0, 1.0)) * 600.0
    phases, totals = make_phases(follows_torque=not at_once), np.zeros(ledger.ENTRIES)
    phases.rotor_currents[:] = 0.0, size
    link = phases.dc_link
    charge_link(link, VOLT * float(draw.choice([0.97, 1.1])))
    link.totals[dc_link.HIGHEST] = link.totals[dc_link.LOWEST] = link.state[dc_link.VOLTAGE]
    link.state[dc_link.PENDING] = float(draw.choice([0.0, 20.0]))
    status = advance_linked_period(
        drive,
        phases,
        angle,
        speed,
        VOLT,
        0.5 + 0.45 * np.cos(float(draw.uniform(0.0, 6.2)) - np.arange(3) * 2.0 * np.pi / 3.0),
        np.full(3, LEG_PWM, np.int64),
        float(draw.choice([np.nan, 0.0, 1.0])),
        0,
        PERIOD,
        totals,
    )
    assert status == COMPLETED
    state = np.concatenate(
        [phases.rotor_currents / LIMIT, phases.magnitudes / (LIMIT * PERIOD), [link.state[0] / VOLT]]
    )
    energy = VOLT * LIMIT * PERIOD
    charge = LIMIT * PERIOD
    scales = {
        ledger.SQUARE: LIMIT * charge,
        ledger.IMPULSE: 6e-3 * 4 * charge,
        ledger.MAGNITUDE: charge,
        ledger.DEVICE: energy,
        ledger.UPPER: energy,
        ledger.EXCHANGED: energy,
        ledger.RETURNED: energy,
        ledger.SWITCHING: energy,
        ledger.PEAK: LIMIT,
    }
    owns = {
        dc_link.SOURCE_CHARGE: charge,
        dc_link.BRIDGE_CHARGE: charge,
        dc_link.FLUX: VOLT * PERIOD,
        dc_link.HIGHEST: VOLT,
        dc_link.LOWEST: VOLT,
    }
    sums = [totals[entry] / scale for entry, scale in scales.items()]
    sums += [link.totals[entry] / owns.get(entry, energy) for entry in range(dc_link.ENTRIES)]
    return _was_passed_at_once(phases), state, np.array(sums)


@pytest.fixture(scope="module")
def pairs() -> list[tuple[tuple[bool, np.ndarray, np.ndarray], tuple[bool, np.ndarray, np.ndarray]]]:
    return [(_advanced(seed, at_once=True), _advanced(seed, at_once=False)) for seed in range(40)]


@pytest.mark.kernel
def test_it_agrees_with_the_general_advance(pairs: list) -> None:  # type: ignore[type-arg]
    for seed, ((_, state, sums), (_, expected, expected_sums)) in enumerate(pairs):
        # The throughput counts magnitudes of whole segments, which may differ.
        apart = np.abs(sums - expected_sums)
        apart[9 + dc_link.THROUGHPUT] = 0.0
        assert np.max(np.abs(state - expected)) <= AGREEMENT, f"seed {seed}: {state - expected}"
        assert np.max(apart) <= AGREEMENT, f"seed {seed}: {apart}"


def test_most_of_these_periods_are_passed_at_once(pairs: list) -> None:  # type: ignore[type-arg]
    assert sum(quick[0] for quick, _ in pairs) >= 20
    assert not any(general[0] for _, general in pairs)
