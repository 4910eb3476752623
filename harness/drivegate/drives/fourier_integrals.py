"""Fourier integrals of a signal of which mean and ends are known on every one of many stretches."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import fsum
from typing import Final

import numpy as np
from numpy.typing import NDArray

_SMALL: Final = 1e-2
_AT_ONCE: Final = 256


@dataclass(frozen=True)
class Stretches:
    """A signal on stretches that follow one another; it may jump between them.

    Attributes
    ----------
    starts, lengths : ndarray, shape (n,)
        When they begin, and how long they are (s).
    means : ndarray, shape (n,)
        Mean of the signal over each.
    rises : ndarray, shape (n,)
        What it has at the end of each less what it has at the start.
    """

    starts: NDArray[np.float64]
    lengths: NDArray[np.float64]
    means: NDArray[np.float64]
    rises: NDArray[np.float64]

    @property
    def mean(self) -> float:
        """Mean of the whole signal."""
        return fsum((self.means * self.lengths).tolist()) / fsum(self.lengths.tolist())


def amplitudes(signal: Stretches, orders: int) -> NDArray[np.float64]:
    """Find the amplitudes of what a signal has besides its mean, under a Hann window.

    Parameters
    ----------
    signal : Stretches
        The signal; its whole length T is the window.
    orders : int
        Number of frequencies, the multiples of 1/T from 1 on.

    Returns
    -------
    ndarray, shape (orders,)
        Amplitudes; a sine of a multiple of 1/T has its own.

    Notes
    -----
    Each stretch is taken as straight, with its own mean and rise, and integrated in closed form. The window,
    ``1 - cos(2 pi t / T)``, adds the halves of the integrals at the neighbouring frequencies.
    """
    length = float(signal.starts[-1] + signal.lengths[-1] - signal.starts[0])
    plain = _integrals(replace(signal, means=signal.means - signal.mean), length, orders + 2)
    windowed = plain[1:-1] - 0.5 * (plain[:-2] + plain[2:])
    found: NDArray[np.float64] = 2.0 / length * np.abs(windowed)
    return found


def _integrals(signal: Stretches, length: float, count: int) -> NDArray[np.complex128]:
    """Integrate the signal times a turning phasor, at the multiples of 1/T from 0 on, shape (count,)."""
    middles = signal.starts - signal.starts[0] + 0.5 * signal.lengths
    found = np.empty(count, dtype=np.complex128)
    for first in range(0, count, _AT_ONCE):
        frequencies = 2.0 * np.pi / length * np.arange(first, min(first + _AT_ONCE, count))[:, np.newaxis]
        half = 0.5 * frequencies * signal.lengths
        flat = np.sinc(half / np.pi) * signal.means * signal.lengths
        sloping = -0.5j * _of_slope(half) * signal.rises * signal.lengths
        found[first : first + _AT_ONCE] = np.sum(
            np.exp(-1j * frequencies * middles) * (flat + sloping), axis=1
        )
    return found


def _of_slope(half: NDArray[np.float64]) -> NDArray[np.float64]:
    """Give ``(sin x - x cos x) / x**2``, by its series where that cancels."""
    safe = np.where(half < _SMALL, 1.0, half)
    whole = (np.sin(safe) - safe * np.cos(safe)) / (safe * safe)
    return np.where(half < _SMALL, half / 3.0 * (1.0 - half * half / 10.0), whole)
