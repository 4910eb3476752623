"""The torque within control periods of a steady state, from the exact plant, and integrals of its harmonics."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from math import fsum, isinf, pi
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.run import DUTY_RATIOS, LEGS
from drivegate_models.contract.duty.signals import LEG_HIGH, LEG_LOW, LEG_OFF
from drivegate_models.errors import HarnessFault
from drivegate_models.machine import ledger
from drivegate_models.machine.rotor_frame import phase_currents
from drivegate_models.machine.sine import cosine_sine
from drivegate_models.pm_ac.plant.advance import PmAcPhases, make_phases
from drivegate_models.pm_ac.plant.drive import Modulator, PmAcDrive, alignment_of, electrical_torque
from drivegate_models.pm_ac.plant.modulator import LOWER, UPPER, make_gates, schedule_gates
from drivegate_models.pm_ac.ripple import NONE_KEPT, swing_of_updates

_SMALL: Final = 1e-2
_Phasors: TypeAlias = tuple[NDArray[np.float64], NDArray[np.float64]]
PIECES: Final = 12
"""Even parts of the time between two updates, besides those at the instants of switching."""
_LEGS_OF: Final = {UPPER: LEG_HIGH, LOWER: LEG_LOW}
_AT_ONCE: Final = Modulator()
_NO_RATIOS: Final = np.zeros((1, 3))


@dataclass(frozen=True)
class Stretches:
    """A signal on stretches that follow one another; it may jump between them."""

    starts: NDArray[np.float64]
    lengths: NDArray[np.float64]
    """When they begin, and how long they are (s), shape (n,)."""
    means: NDArray[np.float64]
    """Mean of the signal over each, shape (n,)."""
    rises: NDArray[np.float64]
    """What it has at the end of each less what it has at the start, shape (n,)."""

    @property
    def mean(self) -> float:
        """Mean of the whole signal."""
        return fsum((self.means * self.lengths).tolist()) / fsum(self.lengths.tolist())


def amplitudes(signal: Stretches, orders: int) -> NDArray[np.float64]:
    """Return the amplitudes of a signal besides its mean under a Hann window, at the first multiples of 1/T.

    T is the signal's length. Each stretch is taken as straight, with its own mean and rise, and integrated in closed
    form. The window, ``1 - cos(2 pi t / T)``, adds the halves of the integrals at the neighbouring frequencies. A sine
    of a multiple of 1/T has its own amplitude.
    """
    length = float(signal.starts[-1] + signal.lengths[-1] - signal.starts[0])
    real, imaginary = _integrals(replace(signal, means=signal.means - signal.mean), length, orders + 2)
    windowed = (plain[1:-1] - 0.5 * (plain[:-2] + plain[2:]) for plain in (real, imaginary))
    squares = [part * part for part in windowed]
    found: NDArray[np.float64] = 2.0 / length * np.sqrt(squares[0] + squares[1])
    return found


def _integrals(
    signal: Stretches, length: float, count: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Integrate the signal times a turning phasor, at the multiples of 1/T from 0 on, both parts of shape (count,)."""
    turn = 2.0 * pi / length
    step = _phasors(turn * (signal.starts - signal.starts[0] + 0.5 * signal.lengths))
    half_step = _phasors(0.5 * turn * signal.lengths)
    here = half = (np.ones(len(signal.starts)), np.zeros(len(signal.starts)))
    real, imaginary = np.empty(count), np.empty(count)
    for order in range(count):
        flat, sloping = _parts(0.5 * turn * order * signal.lengths, *half)
        flat, sloping = flat * signal.means * signal.lengths, -0.5 * sloping * signal.rises * signal.lengths
        # One after the other, in an order that no processor chooses.
        real[order] = np.add.accumulate(here[0] * flat + here[1] * sloping)[-1]
        imaginary[order] = np.add.accumulate(here[0] * sloping - here[1] * flat)[-1]
        here, half = _turned(here, step), _turned(half, half_step)
    return real, imaginary


def _parts(
    half: NDArray[np.float64], cosine: NDArray[np.float64], sine: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return ``sin x / x`` and ``(sin x - x cos x) / x**2``, by their series where that cancels."""
    small = half < _SMALL
    safe = np.where(small, 1.0, half)
    square = half * half
    flat = np.where(small, 1.0 - square / 6.0 * (1.0 - square / 20.0), sine / safe)
    sloping = np.where(small, half / 3.0 * (1.0 - square / 10.0), (sine - safe * cosine) / (safe * safe))
    return flat, sloping


def _phasors(angles: NDArray[np.float64]) -> _Phasors:
    """Return cosines and sines by operations that every processor rounds the same way."""
    pairs = np.array([cosine_sine(angle) for angle in angles.tolist()])
    return pairs[:, 0], pairs[:, 1]


def _turned(phasors: _Phasors, step: _Phasors) -> _Phasors:
    """Turn phasors by angles, which costs less than finding them again."""
    return phasors[0] * step[0] - phasors[1] * step[1], phasors[1] * step[0] + phasors[0] * step[1]


@dataclass(frozen=True)
class TorqueCourse:
    """Torque over some control periods at a held speed."""

    torque: Stretches
    """On the stretches between instants of switching, and shorter ones (N·m)."""
    least: NDArray[np.float64]
    greatest: NDArray[np.float64]
    """Exact extremes within each control period (N·m), shape (n,)."""
    direct: NDArray[np.float64]
    quadrature: NDArray[np.float64]
    """Currents of the rotor frame at the end of each (A), shape (n,)."""


def torque_course(record: DutyRecord, first: int, count: int) -> TorqueCourse:
    """Follow the torque of a run at a held speed over some control periods; the first one is at least number 2."""
    replay = _Replay(record, record.plant_at(first), first)
    for row in range(first, first + count):
        replay.advance(row)
    starts, lengths, means, rises, least, greatest, direct, quadrature = (
        np.array(values) for values in (*replay.stretches, *replay.periods)
    )
    return TorqueCourse(Stretches(starts, lengths, means, rises), least, greatest, direct, quadrature)


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
        angle, speed, link = (float(run.column(name)[row]) for name in ("angle", "speed", "link_mean"))
        turning = self.plant.pole_pairs * speed
        least, greatest = np.inf, -np.inf
        for begin, start, end in self._stretches(row):
            legs = self._legs_at(0.5 * (start + end))
            before = self._torque()
            totals = np.zeros(ledger.ENTRIES)
            phases, length = self.phases, end - start
            instant = angle + turning * (begin + start)
            held = (speed, np.array([link]), _NO_RATIOS, legs[np.newaxis])
            if isinf(swing_of_updates(self.plant, phases, instant, *held, 0, 0, length, totals, NONE_KEPT)):
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
