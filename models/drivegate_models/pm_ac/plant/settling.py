"""Which legs conduct, and which way: at zero current the slopes decide, in every case by one law.

A leg is a relay. Its voltage is `low` while its current is positive and `high` while it is negative; low is at most
high. Where the current is zero, `h` is the voltage at which it would stay so: below `low` the current becomes
positive, above `high` negative, and between both it stays at zero.
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
"""No leg is held at zero current; 0 to 2 is the leg that is."""
EMPTY: Final = 3
"""No current flows."""

_NONE = -1
_NEAR = 1e-14
"""Current that counts as none, over that of the rotor frame."""


class Legs(NamedTuple):
    """What is known of the three legs; updated in place."""

    signs: NDArray[np.int64]
    """Sign of the current, 0 for a leg that is held at zero, shape (3,)."""
    sure: NDArray[np.int64]
    """Sign that the current keeps throughout the advance, 0 where it may change, shape (3,)."""
    gates: NDArray[np.int64]
    """Gate now, shape (3,)."""
    positions: NDArray[np.int64]
    """Entry of the schedule now, shape (3,)."""
    low: NDArray[np.float64]
    """Voltage while the current is positive, shape (3,) (V)."""
    high: NDArray[np.float64]
    """Voltage while it is negative, shape (3,) (V)."""
    voltages: NDArray[np.float64]
    """Voltage now, shape (3,) (V); that of a held leg has no meaning."""


class Settled(NamedTuple):
    """What the legs do until the next event."""

    held: int
    """`FREE`, the leg that is held at zero, or `EMPTY`."""
    frame: RotorFrame
    """Without what rounding has left in held legs."""


def make_legs() -> Legs:
    """Return legs without a current."""
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
    """Return whether the sign of its current matters to a leg."""
    return bool(legs.low[leg] < legs.high[leg])


@inlined
def set_gate(circuit: Circuit, legs: Legs, leg: int, gate: int) -> None:
    """Let a gate change."""
    legs.gates[leg] = gate
    legs.low[leg], legs.high[leg] = leg_voltages(circuit, gate)


@inlined
def _take_sign(legs: Legs, leg: int, sign: int) -> None:
    legs.signs[leg] = sign
    legs.voltages[leg] = legs.low[leg] if sign >= 0 else legs.high[leg]


@inlined
def _project(frame: RotorFrame, leg: int) -> RotorFrame:
    """Return a rotor frame in which a leg has no current at all."""
    cosine, sine = axis_of(frame, leg)
    current = sine * frame.direct + cosine * frame.quadrature
    return RotorFrame(sine * current, cosine * current, frame.cosine, frame.sine)


@inlined
def _emf(circuit: Circuit, frame: RotorFrame, leg: int) -> float:
    """Return the back-EMF of a phase (V)."""
    return -circuit.electrical * circuit.flux * axis_of(frame, leg)[1]


@inlined
def _conducts(circuit: Circuit, legs: Legs, frame: RotorFrame) -> bool:
    """Return whether two legs, without any current, are far enough apart for one to begin."""
    most = -inf
    least = inf
    for leg in range(3):
        emf = _emf(circuit, frame, leg)
        most = max(most, legs.low[leg] - emf)
        least = min(least, legs.high[leg] - emf)
    return most > least + circuit.tie


@inlined
def _margin(circuit: Circuit, legs: Legs, frame: RotorFrame) -> float:
    """Return by how much the slopes agree with the signs of the legs, without any current (A/s)."""
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
    """Give the legs the signs of one of 27 patterns; return how many are held, 3 for a pattern that is none."""
    held = 0
    for leg in range(3):
        sign = pattern % 3 - 1
        pattern //= 3
        if sign != 1 and not is_relay(legs, leg):
            return 3
        held += 1 if sign == 0 else 0
        _take_sign(legs, leg, sign)
    return held


@unallocating
def _begin(circuit: Circuit, legs: Legs, frame: RotorFrame) -> int:
    """Settle legs without any current; return which one stays held."""
    if not _conducts(circuit, legs, frame):
        for leg in range(3):
            _take_sign(legs, leg, 0)
        return EMPTY
    # One pattern agrees with its slopes; at a tie rounding lets none or two do so, and either serves.
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
def _look(circuit: Circuit, legs: Legs, frame: RotorFrame, fixed: int) -> tuple[int, int]:
    """Take over the signs of all currents; return how many legs are at zero, and the last of them."""
    near = _NEAR * (abs(frame.direct) + abs(frame.quadrature)) + circuit.nothing
    count = 0
    last = _NONE
    for leg in range(3):
        if legs.sure[leg] != 0 or leg == fixed:
            _take_sign(legs, leg, legs.sure[leg] if legs.sure[leg] != 0 else legs.signs[leg])
            continue
        current = phase_current(frame, leg)
        if not is_relay(legs, leg):
            # Of no matter to its voltage; what the sign was is forgotten, for it may have changed meanwhile.
            _take_sign(legs, leg, 1 if current >= 0.0 else -1)
        elif legs.signs[leg] == 0 or abs(current) <= near:
            count += 1
            last = leg
            legs.signs[leg] = 0
        else:
            _take_sign(legs, leg, 1 if current > 0.0 else -1)
    return count, last


@inlined
def settle(circuit: Circuit, legs: Legs, frame: RotorFrame, fixed: int, excluded: int) -> Settled:
    """Decide which legs conduct and which way, after anything has changed.

    Parameters
    ----------
    circuit : Circuit
        Constants of the advance.
    legs : Legs
        Gates and voltages as they are now; signs as they were, 0 for a leg whose current has come to zero. Updated.
    frame : RotorFrame
        Currents and angle.
    fixed : int
        Leg whose sign is settled already, or -1.
    excluded : int
        Sign that a single leg at zero has just come from, to which it does not return; 0 for none.

    Returns
    -------
    Settled
        What is held, and the currents.
    """
    count, last = _look(circuit, legs, frame, fixed)
    if count == 0:
        return Settled(FREE, frame)
    if count > 1:
        frame = RotorFrame(0.0, 0.0, frame.cosine, frame.sine)
        return Settled(_begin(circuit, legs, frame), frame)
    voltage = holding_voltage(circuit, frame, last, legs.voltages)[0]
    sign = 0
    if voltage < legs.low[last]:
        sign = 1
    elif voltage > legs.high[last]:
        sign = -1
    if sign == 0 or sign == excluded:
        frame = _project(frame, last)
        _take_sign(legs, last, 0)
        # What one of the others gives the other one takes, also where both are hardly more than rounding.
        ahead = (last + 1) % 3
        flows = 1 if phase_current(frame, ahead) >= 0.0 else -1
        _take_sign(legs, ahead, flows)
        _take_sign(legs, (last + 2) % 3, -flows)
        return Settled(last, frame)
    _take_sign(legs, last, sign)
    return Settled(FREE, frame)
