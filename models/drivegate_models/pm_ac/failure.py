"""Failures in a run of a PM AC drive: a phase, a current sensor, the position sensor, or the shaft itself."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.contract.duty.signals import LEG_OFF
from drivegate_models.loop.shaft import shown_angle

NOTHING: Final = 0
"""Nothing fails."""
OPEN_PHASE: Final = 1
"""Both switches of a leg remain off, as after loss of its gate driver's supply; its diodes still conduct."""
STUCK_CURRENT: Final = 2
"""The measured current of one phase remains constant."""
LOST_POSITION: Final = 3
"""Encoder or Hall switches have no more edges. A position measured without error remains constant, with its speed."""
LOCKED_ROTOR: Final = 4
"""The shaft is locked at standstill."""
LOST_EDGE: Final = 5
"""The next edge of encoder or Hall switches is missing; later edges appear."""
SLIP: Final = 6
"""The magnet of the position sensor has turned on the shaft; angle and edges go on from there."""

_ANGLE, _SPEED = range(2)


class Failure(NamedTuple):
    """A failure, and the last measured values; the arrays are updated in place."""

    kind: int
    """`NOTHING`, `OPEN_PHASE`, `STUCK_CURRENT`, `LOST_POSITION`, `LOCKED_ROTOR`, `LOST_EDGE` or `SLIP`."""
    step: int
    """First control period with the failure."""
    leg: int
    """Index of the leg or phase, from 0."""
    current: NDArray[np.float64]
    """Last measured current of the phase, shape (1,) (A)."""
    shaft: NDArray[np.float64]
    """Last measured angle (rad) and speed (rad/s) of the shaft, shape (2,)."""
    slipped: float
    """Angle of the shaft by which the magnet has turned (rad)."""


def make_failure(kind: int = NOTHING, step: int = 0, leg: int = 0, slipped: float = 0.0) -> Failure:
    """Return a failure at a later control period.

    `kind`: `NOTHING`, `OPEN_PHASE`, `STUCK_CURRENT`, `LOST_POSITION`, `LOCKED_ROTOR`, `LOST_EDGE` or `SLIP`. `step`:
    first control period with the failure. `leg`: index of the leg or phase, from 0. `slipped`: angle of the shaft by
    which the magnet turns (rad).
    """
    return Failure(int(kind), int(step), int(leg), np.zeros(1), np.zeros(2), float(slipped))


@inlined
def has_failed(failure: Failure, kind: int, step: int) -> bool:
    """Return True if a kind of failure is present in a control period."""
    return failure.kind == kind and step >= failure.step


@inlined
def fails_now(failure: Failure, kind: int, step: int) -> bool:
    """Return True if a kind of failure begins with a control period."""
    return failure.kind == kind and step == failure.step


@inlined
def show_failed(
    failure: Failure, step: int, currents: NDArray[np.float64], sense: Any, is_exact: bool
) -> None:
    """Replace measured values by those of a failed sensor.

    `step`: number of the control period. `currents`, shape (3,): measured phase currents (A), replaced. `sense`: its
    angle is replaced if the magnet slips, angle and speed if the position is lost. `is_exact`: true if angle and speed
    are measured without error. A sensor with edges handles missing edges itself.
    """
    if has_failed(failure, STUCK_CURRENT, step):
        currents[failure.leg] = failure.current[0]
    failure.current[0] = currents[failure.leg]
    if is_exact:
        if has_failed(failure, LOST_POSITION, step):
            sense.angle = failure.shaft[_ANGLE]
            sense.speed = failure.shaft[_SPEED]
        if has_failed(failure, SLIP, step):
            sense.angle = shown_angle(sense.angle + failure.slipped)
        failure.shaft[_ANGLE] = sense.angle
        failure.shaft[_SPEED] = sense.speed


@inlined
def fail_legs(failure: Failure, step: int, legs: NDArray[np.int64]) -> None:
    """Turn off the leg of a failed phase in a control period; `legs` are the states of the legs, shape (3,)."""
    if has_failed(failure, OPEN_PHASE, step):
        legs[failure.leg] = LEG_OFF
