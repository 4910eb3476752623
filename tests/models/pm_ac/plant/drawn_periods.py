"""Control periods of drawn PM AC drives, and how far their energy is from closing."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from drivegate_models.machine import ledger
from drivegate_models.machine.advance_status import COMPLETED
from drivegate_models.pm_ac.plant.advance import advance_period, make_phases, stored_energy
from drivegate_models.pm_ac.plant.drive import Modulator, PmAcDrive, make_pm_ac_drive

LOSSES = {
    "copper": ledger.SQUARE,
    "forward drops": ledger.DEVICE,
    "core loss from the link": ledger.CORE_SOURCE,
    "returned energy": ledger.RETURNED,
    "current magnitude": ledger.MAGNITUDE,
}


@dataclass(frozen=True)
class DrawnRun:
    """A drive, its start, and what is constant over its periods."""

    drive: PmAcDrive
    currents: tuple[float, float]
    angle: float
    speed: float
    link: float
    duration: float
    ratios: tuple[tuple[float, float, float], ...]
    modes: tuple[tuple[int, int, int], ...]
    alignments: tuple[int, ...]


def drawn_run(seed: int) -> DrawnRun:
    """Draw a run; the machine is scaled to its link, so that every mode is within reach."""
    draw = np.random.default_rng(seed)

    def pick(*values: float) -> float:
        return float(draw.choice(values))

    link = pick(0.0, 24.0, 96.0, 540.0) if draw.random() < 0.97 else 1e-6
    supply = link or 96.0
    current = pick(2.0, 26.0, 350.0)
    duration = pick(1e-4, 5e-5, 1e-3)
    direct = supply * duration / (current * draw.uniform(0.02, 5.0))
    saliency = pick(1.0, 1.0, 0.25, 2.5, 4.0, 30.0, draw.uniform(0.3, 4.0))
    pole_pairs = int(draw.integers(1, 12))
    base = pick(0.05, 0.3, 1.0) / duration
    edge = pick(0.0, 0.0, 0.02, 0.3)
    count = int(draw.integers(1, 7))
    drive = make_pm_ac_drive(
        pole_pairs=pole_pairs,
        resistance=pick(0.0, 0.0, draw.uniform(1e-6, 3.0)) * min(direct, saliency * direct) / duration,
        direct_inductance=direct,
        quadrature_inductance=saliency * direct,
        magnet_flux=pick(0.0, 1.0, 1.0, 1.0) * supply / math.sqrt(3.0) / base,
        link_voltage=supply,
        current_limit=current,
        core_loss_conductance=pick(0.0, 3e-3),
        switch_drop=pick(0.0, 0.0, 0.05) * supply,
        diode_drop=pick(0.0, 0.0, 0.05) * supply,
        modulator=Modulator(
            dead_time=edge * duration,
            counter_levels=pick(0.0, 8.0, 4096.0),
            minimum_pulse=pick(0.0, 0.01) * duration,
        ),
    )

    def ratio() -> float:
        return pick(0.0, 1.0, 0.5, draw.random(), draw.random())

    choices = [(1, 1, 1), (1, 1, 1), (0, 0, 0), (0, 1, 1), (2, 3, 0), (2, 0, 0), (3, 3, 3), (2, 1, 0)]
    return DrawnRun(
        drive,
        tuple(draw.uniform(-1.0, 1.0, 2) * current * pick(0.0, 1.0, 1e-9)),
        pick(0.0, math.pi / 6.0, draw.uniform(-9.0, 9.0)),
        pick(0.0, 1.0, -1.0, 1.0, draw.uniform(-3.0, 3.0)) * base / pole_pairs,
        link,
        duration,
        tuple((ratio(), ratio(), ratio()) for _ in range(count)),
        tuple(choices[draw.integers(len(choices))] for _ in range(count)),
        tuple(int(draw.integers(0, 3)) for _ in range(count)),
    )


def check_energy(run: DrawnRun) -> float:
    """Check that a run comes to its end with finite numbers and no loss below none; return what energy is missing.

    That is over the throughput: energy exchanged with the link, with the shaft, and stored.
    """
    drive = run.drive
    phases = make_phases(follows_torque=True)
    phases.rotor_currents[:] = run.currents
    totals = np.zeros(ledger.ENTRIES)
    before = stored = stored_energy(drive, phases)
    shaft = 0.0
    throughput = stored
    for k, (ratios, modes, alignment) in enumerate(zip(run.ratios, run.modes, run.alignments, strict=True)):
        period = np.zeros(ledger.ENTRIES)
        angle = run.angle + k * drive.pole_pairs * run.speed * run.duration
        status = advance_period(
            drive,
            phases,
            angle,
            run.speed,
            run.link,
            np.array(ratios),
            np.array(modes, np.int64),
            alignment,
            run.duration,
            period,
        )
        assert status == COMPLETED, f"period {k} ends with status {status}"
        assert np.all(np.isfinite(period)), f"a total of period {k} is not finite: {period}"
        lowest, highest = phases.torque_bounds
        mean = period[ledger.IMPULSE] / run.duration
        slack = 1e-9 * (abs(lowest) + abs(highest))
        assert lowest - slack <= mean <= highest + slack, (
            f"the mean torque {mean} lies outside {lowest} to {highest}"
        )
        ledger.add_period(totals, period)
        stored = stored_energy(drive, phases)
        shaft += run.speed * period[ledger.IMPULSE]
        throughput += period[ledger.EXCHANGED] + abs(run.speed * period[ledger.IMPULSE]) + stored
        assert abs(float(np.sum(phases.currents))) <= 1e-12 * float(np.sum(np.abs(phases.currents))), (
            f"the currents of a star sum to zero, not {phases.currents}"
        )
    for name, entry in LOSSES.items():
        assert totals[entry] >= -1e-12 * throughput, f"{name} is negative: {totals[entry]!r}"
    net = totals[ledger.UPPER] + totals[ledger.LOWER]
    origin = net - totals[ledger.EXCHANGED] + 2.0 * totals[ledger.RETURNED]
    used = drive.resistance * totals[ledger.SQUARE] + shaft + totals[ledger.DEVICE] + stored - before
    return float(max(abs(net - used), abs(origin)) / (throughput + 1e-250))
