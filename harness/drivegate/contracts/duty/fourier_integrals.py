"""Fourier integrals of a signal of which mean and ends are known on every one of many stretches."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import fsum, pi
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from drivegate_models.machine.sine import cosine_sine

_SMALL: Final = 1e-2
_Phasors: TypeAlias = tuple[NDArray[np.float64], NDArray[np.float64]]


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
    squares = [part * part for part in (_windowed(real), _windowed(imaginary))]
    found: NDArray[np.float64] = 2.0 / length * np.sqrt(squares[0] + squares[1])
    return found


def _windowed(plain: NDArray[np.float64]) -> NDArray[np.float64]:
    return plain[1:-1] - 0.5 * (plain[:-2] + plain[2:])


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
