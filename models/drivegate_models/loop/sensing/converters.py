"""Measured currents and supply voltage: gain, offset, noise, quantization and finite range."""

from __future__ import annotations

from math import floor, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined

# The generator of Park and Miller (multiplier of 1993): one number of state, and no product beyond 64 bits.
_MODULUS = 2147483647
_MULTIPLIER = 48271
# The sum of four uniform draws has a variance of a third.
_UNIT_VARIANCE = sqrt(3.0)


class Converters(NamedTuple):
    """Constants of the current and voltage sensors, and the state of their noise."""

    current_step: float
    """Quantization of currents (A); 0 for none."""
    current_range: float
    """Maximum magnitude of a measured current (A)."""
    current_noise: float
    """Standard deviation of the current noise (A)."""
    voltage_step: float
    """Quantization of voltages (V); 0 for none."""
    voltage_range: float
    """Maximum measured voltage (V)."""
    voltage_noise: float
    """Standard deviation of the voltage noise (V)."""
    gains: NDArray[np.float64]
    """Gain of each phase's current sensor, shape (m,) (1)."""
    offsets: NDArray[np.float64]
    """Offset of each phase's current sensor, shape (m,) (A)."""
    random: NDArray[np.int64]
    """State of the noise, shape (1,)."""


def exact_converters(gains: NDArray[np.float64], offsets: NDArray[np.float64]) -> Converters:
    """Return converters without quantization, range limit and noise.

    `gains`, `offsets`, shape (m,): gain (1) and offset (A) of each phase's current sensor. Result: with infinite
    ranges, and 0 for steps and noise.
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
    """Return converters with quantization, errors and noise (paper, Fig. 8).

    - `generator`: source of the random gains and offsets and of the noise's seed.
    - `gains`, `offsets`, shape (m,): gain (1) and offset (A) of each phase's current sensor, to which the random
      errors are added.
    - `current_range`: maximum magnitude of a measured current (A).
    - `current_gain_spread`, `current_offset`: maximum error of a gain (1) and maximum offset (A); those of each phase
      are drawn from uniform distributions.
    - `current_noise`, `voltage_noise`: standard deviations (A, V).
    - `voltage_range`: maximum measured voltage (V); the minimum is 0.
    - `converter_bits`: resolution of the converter (bits).
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
        # From 1 on, since the generator would stay at 0 for ever.
        random=generator.integers(1, _MODULUS, 1),
    )


@inlined
def _noise(random: NDArray[np.int64]) -> float:
    """Return noise of unit variance, the scaled sum of four uniform draws of a multiplicative generator."""
    total = 0.0
    state = random[0]
    for _ in range(4):
        state = (state * _MULTIPLIER) % _MODULUS
        total += state
    random[0] = state
    return (total / _MODULUS - 2.0) * _UNIT_VARIANCE


@inlined
def _converted(value: float, step: float, lowest: float, highest: float) -> float:
    """Return a value quantized by `step`, or unquantized if that is 0, and limited to the range."""
    shown = floor(value / step + 0.5) * step if step > 0.0 else value
    return min(max(shown, lowest), highest)


@inlined
def converted_supply(converters: Converters, supply: float) -> float:
    """Return the measured supply voltage.

    `supply`: mean voltage of the half-sources (V). Result: quantized and limited voltage, with noise (V).
    """
    seen = supply + converters.voltage_noise * _noise(converters.random)
    return _converted(seen, converters.voltage_step, 0.0, converters.voltage_range)


@inlined
def biased_current(
    converters: Converters, phase: int, current: float, magnitude: float
) -> tuple[float, float]:
    """Return a phase's current and its mean magnitude with the gain and offset of its sensor.

    `converters`: only gains and offsets are used. `phase`: index of the phase, from 0. `current`, `magnitude`: true
    current, and mean of its magnitude (A). Returns `current`, `magnitude`: both with gain and offset, before
    quantization and noise (A).
    """
    gain = converters.gains[phase]
    offset = converters.offsets[phase]
    # The sensor measures the signed current; its magnitude is computed afterwards.
    signed_offset = -offset if current < 0.0 else offset
    return gain * current + offset, abs(gain * magnitude + signed_offset)


@inlined
def _noisy_current(converters: Converters, current: float) -> float:
    """Return the measured value of a current that includes its sensor's bias (A)."""
    noisy = current + converters.current_noise * _noise(converters.random)
    greatest = converters.current_range
    return _converted(noisy, converters.current_step, -greatest, greatest)


@inlined
def converted_current(converters: Converters, current: float, magnitude: float) -> tuple[float, float]:
    """Return the measured values of a phase's current and of its mean magnitude.

    `current`, `magnitude`: current and mean of its magnitude, with the sensor's bias (A). Returns `current`,
    `magnitude`: quantized and limited, with noise (A).
    """
    noisy = magnitude + converters.current_noise * _noise(converters.random)
    shown_magnitude = _converted(noisy, converters.current_step, 0.0, converters.current_range)
    return _noisy_current(converters, current), shown_magnitude


@inlined
def shown_current(converters: Converters, phase: int, current: float) -> float:
    """Return the measured value of a phase's current at an instant.

    `phase`: index of the phase, from 0. `current`: true current (A). Result: current with gain, offset and noise,
    quantized and limited (A).
    """
    return _noisy_current(converters, converters.gains[phase] * current + converters.offsets[phase])
