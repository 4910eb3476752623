"""Both energy ledgers of a drive whose link has a capacitor, over drawn drives, links and sources."""

from __future__ import annotations

import numpy as np
import pytest
from tests.models.pm_ac.plant.drawn_periods import drawn_run

from drivegate_models.contract.duty.signals import LEG_HIGH, LEG_LOW
from drivegate_models.machine import ledger
from drivegate_models.machine.advance_status import COMPLETED
from drivegate_models.pm_ac.plant import dc_link
from drivegate_models.pm_ac.plant.advance import make_phases, stored_energy
from drivegate_models.pm_ac.plant.dc_link import DcLink, charge_link, link_energy
from drivegate_models.pm_ac.plant.drive import make_pm_ac_drive
from drivegate_models.pm_ac.plant.linked_advance import advance_linked_period

TOLERANCE = 1e-9
EMPTY_FROM_THE_START = 496
"""A drawn drive whose capacitor is empty and without a source, and whose first pulse takes from it."""


def missing(seed: int) -> tuple[float, float]:
    """Return the greatest energy that a control period of a drawn run misses, of machine and link, over its throughput.

    The throughput is at least that of `loop_kernel`.
    """
    run = drawn_run(seed)
    draw = np.random.default_rng(10_000 + seed)
    volt, current, time = run.drive.link_voltage, run.drive.current_limit, run.duration
    capacitance = current * time / volt * 10.0 ** draw.uniform(-0.5, 3.0)
    resistance = max(volt / current * 10.0 ** draw.uniform(-3.0, -0.3), time / (20.0 * capacitance))
    kind = int(draw.integers(0, 2))
    chopper = float(draw.choice([0.0, 1.0])) * current / volt * draw.uniform(0.1, 2.0)
    link = DcLink(
        capacitance, resistance, kind, 1.5 * volt, 0.0, 0.0, 1.15 * volt, 1.1 * volt, float(chopper)
    )
    if seed % 2 == 1:
        # From an overdamped source to one that rings for long.
        inductance = resistance * resistance * capacitance * 10.0 ** draw.uniform(-1.0, 3.0)
        link = link._replace(source_inductance=max(inductance, (time / 20.0) ** 2 / capacitance))
    drive = run.drive._replace(dc_link=link)
    phases = make_phases(follows_torque=seed % 3 == 0)
    phases.rotor_currents[:] = run.currents
    state = phases.dc_link
    charge_link(state, float(volt * draw.choice([1.0, 1.0, 0.5, 0.0, 1.2, 1.09])))
    brake = float(draw.choice([np.nan, np.nan, 0.3, 1.0, 0.0]))
    source = float(draw.choice([volt, volt, volt, 0.0, 0.7 * volt]))
    windings, charged = stored_energy(drive, phases), link_energy(link, state)
    worst = [0.0, 0.0]
    for k, (ratios, modes, alignment) in enumerate(zip(run.ratios, run.modes, run.alignments, strict=True)):
        period = np.zeros(ledger.ENTRIES)
        state.totals[:] = 0.0
        state.totals[dc_link.HIGHEST] = state.totals[dc_link.LOWEST] = state.state[dc_link.VOLTAGE]
        state.state[dc_link.PENDING] = draw.choice([0.0, 0.05 * volt * current])
        status = advance_linked_period(
            drive,
            phases,
            run.angle + k * drive.pole_pairs * run.speed * time,
            run.speed,
            source,
            np.array(ratios),
            np.array(modes, np.int64),
            brake,
            alignment,
            time,
            period,
        )
        assert status == COMPLETED
        assert np.all(np.isfinite(period))
        assert state.totals[dc_link.LOWEST] >= -1e-12 * volt, "no capacitor charges backward"
        net, now = period[ledger.UPPER] + period[ledger.LOWER], stored_energy(drive, phases)
        shaft = run.speed * period[ledger.IMPULSE]
        used = drive.resistance * period[ledger.SQUARE] + shaft + period[ledger.DEVICE] + now - windings
        through = period[ledger.EXCHANGED] + abs(shaft) + now + windings
        least = 1e-6 * volt * current * time
        worst[0] = max(worst[0], abs(net - used) / max(through, least))
        windings = now
        account, now = state.totals, link_energy(link, state)
        used = sum(
            account[entry] for entry in (dc_link.RESISTED, dc_link.BURNT, dc_link.SUPPLIED, dc_link.BRIDGE)
        )
        lost = abs(account[dc_link.DRAWN] - used - (now - charged))
        least += 1e-6 * volt * volt / resistance * time + 1e-4 * (now + charged)
        worst[1] = max(worst[1], lost / max(account[dc_link.THROUGHPUT], least))
        charged = now
    return worst[0], worst[1]


@pytest.mark.parametrize("seed", [*range(40), EMPTY_FROM_THE_START])
def test_the_energies_of_machine_and_link_close(seed: int) -> None:
    machine, link = missing(seed)
    assert machine <= TOLERANCE
    assert link <= TOLERANCE


@pytest.mark.kernel
@pytest.mark.parametrize(("leg", "ratio"), [(0, 1.0), (2, 1.5)])
def test_what_is_exchanged_while_currents_cross_zero_does_not_depend_on_the_division(
    leg: int, ratio: float
) -> None:
    angle = 0.7
    drive = make_pm_ac_drive(
        pole_pairs=4,
        resistance=0.4,
        magnet_flux=6e-3,
        direct_inductance=2e-4,
        quadrature_inductance=ratio * 2e-4,
        link_voltage=48.0,
        current_limit=12.0,
        dc_link=DcLink(1e-4, 0.1, dc_link.BATTERY, 60.0, 5.0, 9.0),
    )
    # The current of the leg at the upper rail, which is that of the link, rises through zero.
    apart = leg * 2.0 * np.pi / 3.0 - angle
    currents = -1.2 * np.array([np.cos(apart), np.sin(apart)])
    modes = np.full(3, LEG_LOW)
    modes[leg] = LEG_HIGH
    found = []
    for parts in (1, 40):
        phases, totals = make_phases(), np.zeros(ledger.ENTRIES)
        phases.rotor_currents[:] = currents
        charge_link(phases.dc_link, 47.0)
        for k in range(parts):
            time = 2e-5 / parts
            assert (
                advance_linked_period(
                    drive,
                    phases,
                    angle + 400.0 * 4 * k * time,
                    400.0,
                    48.0,
                    np.zeros(3),
                    modes,
                    np.nan,
                    0,
                    time,
                    totals,
                )
                == COMPLETED
            )
        found.append((totals[ledger.EXCHANGED], totals[ledger.MAGNITUDE], totals[ledger.PEAK]))
    assert found[0] == pytest.approx(found[1], rel=1e-9)


@pytest.mark.nightly
def test_they_close_on_a_thousand_drives() -> None:
    for seed in range(1000):
        assert max(missing(seed)) <= TOLERANCE, f"seed {seed}"
