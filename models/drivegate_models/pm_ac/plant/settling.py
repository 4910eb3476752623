"""Conducting legs and the signs of their currents: at zero current the slopes decide, always by the same law.

A leg is a relay. Its voltage is `low` while its current is positive and `high` while it is negative; low is at most
high. At zero current, `h` is the voltage at which the current remains zero. If `h` is below `low` the current becomes
positive, above `high` negative, and in between it remains zero.
"""

from __future__ import annotations

from math import inf
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.machine.rotor_frame import RotorFrame, axis_of, phase_current
from drivegate_models.pm_ac.plant.circuit import Circuit, holding_voltage, leg_voltages, phase_slope

FREE: Final = -1
"""No leg is held at zero current; otherwise 0 to 2 is the held leg."""
EMPTY: Final = 3
"""No current flows."""

_NONE = -1
_NEAR = 1e-14
"""Current that counts as zero, relative to the current in the rotor frame."""


class Legs(NamedTuple):
    """State of the three legs; updated in place."""

    signs: NDArray[np.int64]
    """Sign of the current, 0 for a leg held at zero, shape (3,)."""
    sure: NDArray[np.int64]
    """Sign of the current if it cannot change in the advance, otherwise 0, shape (3,)."""
    gates: NDArray[np.int64]
    """Present gate, shape (3,)."""
    positions: NDArray[np.int64]
    """Present entry of the schedule, shape (3,)."""
    low: NDArray[np.float64]
    """Voltage while the current is positive, shape (3,) (V)."""
    high: NDArray[np.float64]
    """Voltage while the current is negative, shape (3,) (V)."""
    voltages: NDArray[np.float64]
    """Present voltage, shape (3,) (V); undefined for a held leg until the end of an advance."""


class Settled(NamedTuple):
    """State until the next event."""

    held: int
    """`FREE`, the leg held at zero, or `EMPTY`."""
    frame: RotorFrame
    """Currents in the rotor frame, with exact zeros in held legs."""


def make_legs() -> Legs:
    return Legs(
        np.zeros(3, np.int64),
        np.zeros(3, np.int64),
        np.zeros(3, np.int64),
        np.zeros(3, np.int64),
        np.zeros(3),
        np.zeros(3),
        np.zeros(3),
    )


@inlined
def is_relay(legs: Legs, leg: int) -> bool:
    """Return True if a leg's voltage depends on the sign of its current."""
    return bool(legs.low[leg] < legs.high[leg])


@inlined
def set_gate(circuit: Circuit, legs: Legs, leg: int, gate: int) -> None:
    """Set the gate of a leg and its two voltages."""
    legs.gates[leg] = gate
    legs.low[leg], legs.high[leg] = leg_voltages(circuit, gate)


@inlined
def _set_sign(legs: Legs, leg: int, sign: int) -> None:
    legs.signs[leg] = sign
    legs.voltages[leg] = legs.low[leg] if sign >= 0 else legs.high[leg]


@inlined
def _project(frame: RotorFrame, leg: int) -> RotorFrame:
    """Return the rotor frame with exactly zero current in a leg."""
    cosine, sine = axis_of(frame, leg)
    current = sine * frame.direct + cosine * frame.quadrature
    return RotorFrame(sine * current, cosine * current, frame.cosine, frame.sine)


@inlined
def _emf(circuit: Circuit, frame: RotorFrame, leg: int) -> float:
    """Return the back-EMF of a phase (V)."""
    return -circuit.electrical * circuit.flux * axis_of(frame, leg)[1]


@inlined
def supplied_neutral(circuit: Circuit, legs: Legs, frame: RotorFrame, leg: int) -> float:
    """Return the voltage of the neutral if, without any current, a leg supplies the dividers (V)."""
    return float(legs.low[leg] - _emf(circuit, frame, leg))


@inlined
def show_voltages(circuit: Circuit, legs: Legs, settled: Settled) -> None:
    """Write the voltages of held legs, as dividers to the lower rail show them.

    Without any current, the dividers lower the neutral until a leg supplies them.
    """
    frame = settled.frame
    if settled.held == EMPTY:
        neutral = -inf
        for leg in range(3):
            neutral = max(neutral, supplied_neutral(circuit, legs, frame, leg))
        for leg in range(3):
            legs.voltages[leg] = neutral + _emf(circuit, frame, leg)
    elif settled.held != FREE:
        legs.voltages[settled.held] = holding_voltage(circuit, frame, settled.held, legs.voltages)[0]


@inlined
def _conducts(circuit: Circuit, legs: Legs, frame: RotorFrame) -> bool:
    """Return True if, without any current, the voltages of two legs differ enough to start one."""
    most = -inf
    least = inf
    for leg in range(3):
        most = max(most, supplied_neutral(circuit, legs, frame, leg))
        least = min(least, legs.high[leg] - _emf(circuit, frame, leg))
    return most > least + circuit.tie


@inlined
def _margin(circuit: Circuit, legs: Legs, frame: RotorFrame) -> float:
    """Return the margin by which the slopes agree with the signs of the legs, without any current (A/s)."""
    margin = inf
    for leg in range(3):
        if legs.signs[leg] == 0:
            voltage, gain = holding_voltage(circuit, frame, leg, legs.voltages)
            margin = min(margin, gain * (voltage - legs.low[leg]), gain * (legs.high[leg] - voltage))
            legs.voltages[leg] = voltage
    for leg in range(3):
        if legs.signs[leg] != 0 and is_relay(legs, leg):
            slope = phase_slope(circuit, frame, leg, legs.voltages[0], legs.voltages[1], legs.voltages[2])
            margin = min(margin, legs.signs[leg] * slope)
    return margin


@inlined
def _set_pattern(legs: Legs, pattern: int) -> int:
    """Set the legs to the signs of one of 27 patterns; return the number of held legs, 3 for an invalid pattern."""
    held = 0
    for leg in range(3):
        sign = pattern % 3 - 1
        pattern //= 3
        if sign != 1 and not is_relay(legs, leg):
            return 3
        held += 1 if sign == 0 else 0
        _set_sign(legs, leg, sign)
    return held


@unallocating
def _start_from_zero(circuit: Circuit, legs: Legs, frame: RotorFrame) -> int:
    """Determine the signs of legs without any current; return the held leg, `FREE` or `EMPTY`."""
    if not _conducts(circuit, legs, frame):
        for leg in range(3):
            _set_sign(legs, leg, 0)
        return EMPTY
    # One pattern agrees with its slopes. At a tie, by rounding, none or two agree, and either is valid.
    best = 0
    margin = -inf
    for pattern in range(27):
        if _set_pattern(legs, pattern) <= 1:
            agreement = _margin(circuit, legs, frame)
            if agreement > margin:
                margin = agreement
                best = pattern
    _set_pattern(legs, best)
    for leg in range(3):
        if legs.signs[leg] == 0:
            return leg
    return FREE


@inlined
def _update_signs(circuit: Circuit, legs: Legs, frame: RotorFrame, fixed: int) -> tuple[int, int]:
    """Update the signs from all currents; return the number of legs at zero, and the last of them."""
    near = _NEAR * (abs(frame.direct) + abs(frame.quadrature)) + circuit.nothing
    count = 0
    last = _NONE
    for leg in range(3):
        if legs.sure[leg] != 0 or leg == fixed:
            _set_sign(legs, leg, legs.sure[leg] if legs.sure[leg] != 0 else legs.signs[leg])
            continue
        current = phase_current(frame, leg)
        if not is_relay(legs, leg):
            # The sign does not affect the voltage, and may have changed meanwhile.
            _set_sign(legs, leg, 1 if current >= 0.0 else -1)
        elif legs.signs[leg] == 0 or abs(current) <= near:
            count += 1
            last = leg
            legs.signs[leg] = 0
        else:
            _set_sign(legs, leg, 1 if current > 0.0 else -1)
    return count, last


@inlined
def settle(circuit: Circuit, legs: Legs, frame: RotorFrame, fixed: int, excluded: int) -> Settled:
    """Determine the conducting legs and their signs, after any change.

    `legs`: with present gates and voltages and the previous signs, 0 for a leg whose current has reached zero.
    Updated. `fixed`: leg with a known sign, or -1. `excluded`: previous sign of a single leg at zero, to which it does
    not return; 0 for none.
    """
    count, last = _update_signs(circuit, legs, frame, fixed)
    if count == 0:
        return Settled(FREE, frame)
    if count > 1:
        frame = RotorFrame(0.0, 0.0, frame.cosine, frame.sine)
        return Settled(_start_from_zero(circuit, legs, frame), frame)
    voltage = holding_voltage(circuit, frame, last, legs.voltages)[0]
    sign = 0
    if voltage < legs.low[last]:
        sign = 1
    elif voltage > legs.high[last]:
        sign = -1
    if sign == 0 or sign == excluded:
        frame = _project(frame, last)
        _set_sign(legs, last, 0)
        # The currents of the other two legs are opposite, even if both are within rounding.
        ahead = (last + 1) % 3
        flows = 1 if phase_current(frame, ahead) >= 0.0 else -1
        _set_sign(legs, ahead, flows)
        _set_sign(legs, (last + 2) % 3, -flows)
        return Settled(last, frame)
    _set_sign(legs, last, sign)
    return Settled(FREE, frame)
