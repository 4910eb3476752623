"""The torque within control periods of a steady state: recorded commands given to the exact plant once more."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.contracts.duty.fourier_integrals import Stretches
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.run import DUTY_RATIOS, LEGS
from drivegate_models.contract.duty.signals import LEG_HIGH, LEG_LOW, LEG_OFF
from drivegate_models.errors import HarnessFault
from drivegate_models.machine import ledger
from drivegate_models.machine.rotor_frame import phase_currents
from drivegate_models.pm_ac.plant.advance import PmAcPhases, advance_period, make_phases
from drivegate_models.pm_ac.plant.drive import CENTRED, Modulator, PmAcDrive, alignment_of, electrical_torque
from drivegate_models.pm_ac.plant.modulator import LOWER, UPPER, make_gates, schedule_gates

PIECES: Final = 12
"""Even parts of the time between two updates, besides those at the instants of switching."""
_LEGS_OF: Final = {UPPER: LEG_HIGH, LOWER: LEG_LOW}
_AT_ONCE: Final = Modulator()
_NO_RATIOS: Final = np.zeros(3)


@dataclass(frozen=True)
class TorqueCourse:
    """Torque over some control periods at a held speed."""

    torque: Stretches
    """On the stretches between instants of switching, and shorter ones (N·m)."""
    period: float
    """Control period (s)."""
    least: NDArray[np.float64]
    greatest: NDArray[np.float64]
    """Exact extremes within each control period (N·m), shape (n,)."""
    direct: NDArray[np.float64]
    quadrature: NDArray[np.float64]
    """Currents of the rotor frame at the end of each (A), shape (n,)."""


def torque_course(record: DutyRecord, first: int, count: int) -> TorqueCourse:
    """Follow the torque of a run at a held speed over some control periods; the first one is at least number 2."""
    drive: Any = record.drive
    plant: PmAcDrive = drive
    replay = _Replay(record, plant, first)
    for row in range(first, first + count):
        replay.advance(row)
    starts, lengths, means, rises, least, greatest, direct, quadrature = (
        np.array(values) for values in (*replay.stretches, *replay.periods)
    )
    length = record.scenario.control_period_s
    return TorqueCourse(Stretches(starts, lengths, means, rises), length, least, greatest, direct, quadrature)


class _Replay:
    """The plant at the start of a control period, and what has been seen of it."""

    def __init__(self, record: DutyRecord, plant: PmAcDrive, first: int) -> None:
        self.record, self.plant = record, plant._replace(modulator=_AT_ONCE)
        self.modulator = plant.modulator
        self.delay = 1 if plant.modulator.update_delay > 0 else 0
        self.length = record.scenario.control_period_s
        self.update = self.length / plant.modulator.control_every
        self.gates = make_gates()
        self.phases = self._phases_before(first)
        self._schedule(first - 1)
        self.stretches: tuple[list[float], ...] = ([], [], [], [])
        self.periods: tuple[list[float], ...] = ([], [], [], [])

    def _phases_before(self, row: int) -> PmAcPhases:
        run = self.record.run
        phases = make_phases(follows_torque=True)
        direct, quadrature = (run.column(name)[row - 1] for name in ("direct", "quadrature"))
        phases.rotor_currents[:] = direct, quadrature
        angle = run.column("angle")[row : row + 1].copy()
        currents = phase_currents(np.array([direct]), np.array([quadrature]), angle)[0]
        phases.legs.signs[:] = np.sign(currents).astype(np.int64)
        return phases

    def _schedule(self, row: int) -> None:
        """Make the instants of switching between two updates of the modulator in a control period."""
        command = self.record.run.commands[row - self.delay]
        ratios = np.array([float(command[name]) for name in DUTY_RATIOS])
        legs = np.array([int(command[name]) for name in LEGS])
        alignment = alignment_of(self.modulator.updates, row)
        schedule_gates(self.modulator, self.gates, ratios, legs, alignment, self.update)

    def advance(self, row: int) -> None:
        """Advance by a control period, stretch by stretch."""
        run = self.record.run
        angle, speed, link = (float(run.column(name)[row]) for name in ("angle", "speed", "link"))
        turning = self.plant.pole_pairs * speed
        least, greatest = np.inf, -np.inf
        for begin, start, end in self._stretches(row):
            legs = self._legs_at(0.5 * (start + end))
            before = self._torque()
            totals = np.zeros(ledger.ENTRIES)
            phases, length = self.phases, end - start
            if advance_period(
                self.plant,
                phases,
                angle + turning * (begin + start),
                speed,
                link,
                _NO_RATIOS,
                legs,
                CENTRED,
                length,
                totals,
            ):
                raise HarnessFault(f"the plant could not follow the commands of step {row}")
            seen = (row * self.length + (begin + start), length, totals[ledger.IMPULSE] / length)
            for values, value in zip(self.stretches, (*seen, self._torque() - before), strict=True):
                values.append(float(value))
            least, greatest = min(least, phases.torque_bounds[0]), max(greatest, phases.torque_bounds[1])
        for values, value in zip(self.periods, (least, greatest, *self.phases.rotor_currents), strict=True):
            values.append(float(value))

    def _stretches(self, row: int) -> Iterator[tuple[float, float, float]]:
        """Schedule each update of a control period; yield its begin and, from there, start and end of stretches."""
        for number in range(self.modulator.control_every):
            self._schedule(row)
            for start, end in pairwise(self._instants().tolist()):
                yield number * self.update, start, end

    def _torque(self) -> float:
        return float(electrical_torque(self.plant, *map(float, self.phases.rotor_currents)))

    def _instants(self) -> NDArray[np.float64]:
        gates = self.gates
        switching = [gates.times[leg, : gates.counts[leg]] for leg in range(3)]
        even = np.linspace(0.0, self.update, PIECES + 1)
        instants = np.unique(np.concatenate([even, *switching]))
        return instants[instants <= self.update]

    def _legs_at(self, time: float) -> NDArray[np.int64]:
        """Return what each leg does, as commands say it, once dead times are counted as off."""
        gates = self.gates
        legs = np.empty(3, np.int64)
        for leg in range(3):
            entry = int(np.searchsorted(gates.times[leg, : gates.counts[leg]], time, side="right")) - 1
            legs[leg] = _LEGS_OF.get(int(gates.gates[leg, entry]), LEG_OFF)
        return legs
