"""Integrals of the terminals' voltages over a segment, for drives that sense their means.

A leg with current is at a rail, apart from a drop. The voltage of a held leg is known by its series. Without any
current the terminals differ by the EMFs, and the leg that supplies the dividers is at its own voltage.
"""

from __future__ import annotations

from math import inf, pi
from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.machine.rotor_frame import RotorFrame, axis_of, turned
from drivegate_models.machine.sine import cosine_sine
from drivegate_models.pm_ac.plant.circuit import Circuit, is_on_upper_rail
from drivegate_models.pm_ac.plant.polynomial import integral_to
from drivegate_models.pm_ac.plant.series import Series
from drivegate_models.pm_ac.plant.settling import EMPTY, FREE, Legs, supplied_neutral

# Turn of the rotor in which at most one leg takes the dividers over from another (rad): that occurs at every third
# of a turn, apart from the drops. Number of halvings to that instant.
_STEP: Final = 0.125 * pi
_HALVINGS: Final = 60


@inlined
def _rotated(frame: RotorFrame, angle: float) -> RotorFrame:
    """Return a rotor without current that has turned by an angle (rad)."""
    by_cosine, by_sine = cosine_sine(angle)
    cosine, sine = turned(frame, by_cosine, by_sine)
    return RotorFrame(0.0, 0.0, cosine, sine)


@inlined
def _supplying(circuit: Circuit, legs: Legs, frame: RotorFrame) -> int:
    """Return the leg that supplies the dividers while no current flows."""
    most, chosen = -inf, 0
    for leg in range(3):
        neutral = supplied_neutral(circuit, legs, frame, leg)
        if neutral > most:
            most, chosen = neutral, leg
    return chosen


@inlined
def _taken_over(
    circuit: Circuit, legs: Legs, frame: RotorFrame, first: int, last: int, length: float
) -> float:
    """Return the time within a length (s) at which another leg takes the dividers over (s), by bisection."""
    low, high = 0.0, length
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        there = _rotated(frame, circuit.electrical * middle)
        before = supplied_neutral(circuit, legs, there, first)
        if before > supplied_neutral(circuit, legs, there, last):
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@inlined
def _add_supplied(
    circuit: Circuit,
    legs: Legs,
    frame: RotorFrame,
    leg: int,
    length: float,
    rise: float,
    volt_seconds: NDArray[np.float64],
) -> None:
    """Add a stretch without a current in which one leg supplies the dividers."""
    after = _rotated(frame, circuit.electrical * length)
    upper = rise if is_on_upper_rail(legs.gates[leg], 0) else 0.0
    own = legs.low[leg] * length + upper
    own -= circuit.flux * (axis_of(after, leg)[0] - axis_of(frame, leg)[0])
    for other in range(3):
        volt_seconds[other] += own + circuit.flux * (axis_of(after, other)[0] - axis_of(frame, other)[0])


@inlined
def _add_idle(
    circuit: Circuit,
    legs: Legs,
    frame: RotorFrame,
    length: float,
    rise: float,
    volt_seconds: NDArray[np.float64],
) -> None:
    """Add a stretch without a current."""
    parts = 1 + int(abs(circuit.electrical) * length / _STEP)
    part = length / parts
    begin = frame
    for number in range(parts):
        end = _rotated(frame, circuit.electrical * part * (number + 1))
        first, last = _supplying(circuit, legs, begin), _supplying(circuit, legs, end)
        share = rise / parts
        if first == last:
            _add_supplied(circuit, legs, begin, first, part, share, volt_seconds)
        else:
            passed = _taken_over(circuit, legs, begin, first, last, part)
            _add_supplied(circuit, legs, begin, first, passed, share * passed / part, volt_seconds)
            there = _rotated(begin, circuit.electrical * passed)
            left = part - passed
            _add_supplied(circuit, legs, there, last, left, share * left / part, volt_seconds)
        begin = end


@inlined
def add_steady(voltages: NDArray[np.float64], length: float, volt_seconds: NDArray[np.float64]) -> None:
    """Add a time (s) with constant voltages (V), shape (3,), if the integrals are computed."""
    for leg in range(volt_seconds.size):
        volt_seconds[leg] += voltages[leg] * length


@unallocating
def add_volt_seconds(
    circuit: Circuit,
    legs: Legs,
    series: Series,
    frame: RotorFrame,
    held: int,
    count: int,
    length: float,
    share: float,
    rise: float,
    volt_seconds: NDArray[np.float64],
) -> None:
    """Add the integrals of the terminals' voltages to the lower rail over the first part of a segment.

    - `series`: with the voltage of a held leg in the whole segment, of `count` coefficients.
    - `frame`: rotor at the start.
    - `held`: `FREE`, the held leg, or `EMPTY`.
    - `length`, `share`: length of the whole segment (s), and the share of it that has passed (1).
    - `rise`: integral of the link's voltage beyond that at the start (V s); 0 for an ideal link.
    - `volt_seconds`, shape (3,): added to (V s).
    """
    passed = length * share
    if held == EMPTY:
        _add_idle(circuit, legs, frame, passed, rise, volt_seconds)
        return
    for leg in range(3):
        if held != FREE and leg == held:
            volt_seconds[leg] += length * integral_to(series.holding, count, share)
            continue
        volt_seconds[leg] += legs.voltages[leg] * passed
        if is_on_upper_rail(legs.gates[leg], legs.signs[leg]):
            volt_seconds[leg] += rise


@inlined
def is_followed(volt_seconds: NDArray[np.float64]) -> bool:
    """Return True if the integrals of the voltages are computed."""
    return volt_seconds.size > 0
