"""Currents and supply as converters show them: a gain, an offset, noise, finite steps and a finite range."""

from __future__ import annotations

from math import floor, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined

# The generator of Park and Miller (multiplier of 1993): one number of state, and no product beyond 64 bits.
_MODULUS = 2147483647
_MULTIPLIER = 48271
# The sum of four even draws has a variance of a third.
_UNIT_VARIANCE = sqrt(3.0)


class Converters(NamedTuple):
    """Constants of the current and voltage sensors, and the state of their noise."""

    current_step: float
    """Step of the converter (A)."""
    current_range: float
    """Greatest current shown (A)."""
    current_noise: float
    """Standard deviation (A)."""
    voltage_step: float
    """Step of the converter (V)."""
    voltage_range: float
    """Greatest voltage shown (V)."""
    voltage_noise: float
    """Standard deviation (V)."""
    gains: NDArray[np.float64]
    """Gain of each phase's current sensor, shape (m,) (1)."""
    offsets: NDArray[np.float64]
    """Offset of each phase's current sensor, shape (m,) (A)."""
    random: NDArray[np.int64]
    """State of the noise, shape (1,)."""


def exact_converters(gains: NDArray[np.float64], offsets: NDArray[np.float64]) -> Converters:
    """Make converters without steps, range and noise.

    Parameters
    ----------
    gains, offsets : ndarray, shape (m,)
        Gain (1) and offset (A) of each phase's current sensor.

    Returns
    -------
    Converters
        The converters.
    """
    return Converters(
        current_step=0.0,
        current_range=np.inf,
        current_noise=0.0,
        voltage_step=0.0,
        voltage_range=np.inf,
        voltage_noise=0.0,
        gains=gains,
        offsets=offsets,
        random=np.ones(1, np.int64),
    )


def real_converters(
    generator: np.random.Generator,
    gains: NDArray[np.float64],
    offsets: NDArray[np.float64],
    *,
    current_range: float,
    current_gain_spread: float,
    current_offset: float,
    current_noise: float,
    voltage_range: float,
    voltage_noise: float,
    converter_bits: int,
) -> Converters:
    """Make converters with finite steps, errors and noise (paper, Fig. 8).

    Parameters
    ----------
    generator : numpy.random.Generator
        Where gains, offsets and the noise's beginning are drawn from.
    gains, offsets : ndarray, shape (m,)
        Gain (1) and offset (A) that a phase's current sensor has besides those that are drawn.
    current_range : float
        The converter shows currents from minus to plus this (A).
    current_gain_spread, current_offset : float
        Greatest error of a gain (1) and greatest offset (A); each phase's are drawn evenly.
    current_noise, voltage_noise : float
        Standard deviations (A, V).
    voltage_range : float
        The converter shows voltages from 0 to this (V).
    converter_bits : int
        Bits of the converter.

    Returns
    -------
    Converters
        The converters.
    """
    steps = 2**converter_bits
    phases = gains.size
    return Converters(
        current_step=2.0 * current_range / steps,
        current_range=current_range,
        current_noise=current_noise,
        voltage_step=voltage_range / steps,
        voltage_range=voltage_range,
        voltage_noise=voltage_noise,
        gains=gains * (1.0 + current_gain_spread * generator.uniform(-1.0, 1.0, phases)),
        offsets=offsets + current_offset * generator.uniform(-1.0, 1.0, phases),
        random=generator.integers(1, _MODULUS, 1),
    )


@inlined
def _noise(random: NDArray[np.int64]) -> float:
    """Return noise of unit variance, the scaled sum of four even draws of a multiplicative generator."""
    total = 0.0
    state = random[0]
    for _ in range(4):
        state = (state * _MULTIPLIER) % _MODULUS
        total += state
    random[0] = state
    return (total / _MODULUS - 2.0) * _UNIT_VARIANCE


@inlined
def _converted(value: float, step: float, lowest: float, highest: float) -> float:
    """Return what a converter shows of a value; with a step of 0 only its range counts."""
    shown = floor(value / step + 0.5) * step if step > 0.0 else value
    return min(max(shown, lowest), highest)


@inlined
def converted_supply(converters: Converters, supply: float) -> float:
    """Return what is shown of the supply.

    Parameters
    ----------
    converters : Converters
        With finite steps; their noise goes on.
    supply : float
        Mean voltage of the half-sources (V).

    Returns
    -------
    float
        (V).
    """
    seen = supply + converters.voltage_noise * _noise(converters.random)
    return _converted(seen, converters.voltage_step, 0.0, converters.voltage_range)


@inlined
def biased_current(
    converters: Converters, phase: int, current: float, magnitude: float
) -> tuple[float, float]:
    """Return a phase's current and its mean magnitude with the gain and offset of its sensor.

    Parameters
    ----------
    converters : Converters
        With the gains and offsets.
    phase : int
        Index of the phase.
    current, magnitude : float
        True current, and mean of its magnitude (A).

    Returns
    -------
    current, magnitude : float
        (A).
    """
    gain = converters.gains[phase]
    offset = converters.offsets[phase]
    # The sensor sees the signed current, and only then is its magnitude taken.
    signed_offset = -offset if current < 0.0 else offset
    return gain * current + offset, abs(gain * magnitude + signed_offset)


@inlined
def _noisy_current(converters: Converters, current: float) -> float:
    """Return what a converter shows of a current with its sensor's bias (A)."""
    noisy = current + converters.current_noise * _noise(converters.random)
    greatest = converters.current_range
    return _converted(noisy, converters.current_step, -greatest, greatest)


@inlined
def converted_current(converters: Converters, current: float, magnitude: float) -> tuple[float, float]:
    """Return what is shown of a phase's current and of its mean magnitude.

    Parameters
    ----------
    converters : Converters
        With finite steps; their noise goes on.
    current, magnitude : float
        Current with its sensor's bias, and mean of its magnitude (A).

    Returns
    -------
    current, magnitude : float
        (A).
    """
    noisy = magnitude + converters.current_noise * _noise(converters.random)
    shown_magnitude = _converted(noisy, converters.current_step, 0.0, converters.current_range)
    return _noisy_current(converters, current), shown_magnitude


@inlined
def shown_current(converters: Converters, phase: int, current: float) -> float:
    """Return what is shown of a phase's current at an instant.

    Parameters
    ----------
    converters : Converters
        With finite steps; their noise goes on.
    phase : int
        Index of the phase.
    current : float
        True current (A).

    Returns
    -------
    float
        (A).
    """
    return _noisy_current(converters, converters.gains[phase] * current + converters.offsets[phase])
