"""What fails in a run of a PM AC drive: a phase, a current sensor, the position of the shaft, or the shaft itself."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.contract.duty.signals import LEG_OFF

NOTHING: Final = 0
"""Nothing fails."""
OPEN_PHASE: Final = 1
"""Both switches of a leg stay off, as where its gate driver loses its supply; its diodes remain."""
STUCK_CURRENT: Final = 2
"""What is shown of one phase's current stays what it was."""
LOST_POSITION: Final = 3
"""No edges of encoder or Hall switches come any more; a position that is shown as it is stays, with its speed."""
LOCKED_ROTOR: Final = 4
"""The shaft stands."""
LOST_EDGE: Final = 5
"""The next edge of encoder or Hall switches does not come, and those behind it do."""

_ANGLE, _SPEED = range(2)


class Failure(NamedTuple):
    """What fails, and what was shown last; the arrays are updated in place."""

    kind: int
    """`NOTHING`, `OPEN_PHASE`, `STUCK_CURRENT`, `LOST_POSITION`, `LOCKED_ROTOR` or `LOST_EDGE`."""
    step: int
    """Control period from which on it has failed."""
    leg: int
    """The leg or phase, from 0."""
    current: NDArray[np.float64]
    """Current shown last of the phase, shape (1,) (A)."""
    shaft: NDArray[np.float64]
    """Angle (rad) and speed (rad/s) of the shaft shown last, shape (2,)."""


def make_failure(kind: int = NOTHING, step: int = 0, leg: int = 0) -> Failure:
    """Make a failure that is still to come.

    Parameters
    ----------
    kind : int
        `NOTHING`, `OPEN_PHASE`, `STUCK_CURRENT`, `LOST_POSITION`, `LOCKED_ROTOR` or `LOST_EDGE`.
    step : int
        Control period from which on it has failed.
    leg : int
        The leg or phase, from 0.

    Returns
    -------
    Failure
        Of which nothing has been shown.
    """
    return Failure(int(kind), int(step), int(leg), np.zeros(1), np.zeros(2))


@inlined
def has_failed(failure: Failure, kind: int, step: int) -> bool:
    """Return whether something has failed in a control period."""
    return failure.kind == kind and step >= failure.step


@inlined
def fails_now(failure: Failure, kind: int, step: int) -> bool:
    """Return whether something fails with the start of a control period."""
    return failure.kind == kind and step == failure.step


@inlined
def show_failed(
    failure: Failure, step: int, currents: NDArray[np.float64], sense: Any, is_exact: bool
) -> None:
    """Replace what is sensed by what a failed sensor shows.

    Parameters
    ----------
    failure : Failure
        Keeps what is shown until it fails.
    step : int
        Number of the control period.
    currents : ndarray, shape (3,)
        Sensed phase currents (A), replaced.
    sense : record of DUTY_SENSE
        Its angle and speed are replaced where the position is lost.
    is_exact : bool
        Whether angle and speed are shown as they are, not by edges, whose sensor knows itself how long none came.
    """
    if has_failed(failure, STUCK_CURRENT, step):
        currents[failure.leg] = failure.current[0]
    failure.current[0] = currents[failure.leg]
    if is_exact:
        if has_failed(failure, LOST_POSITION, step):
            sense.angle = failure.shaft[_ANGLE]
            sense.speed = failure.shaft[_SPEED]
        failure.shaft[_ANGLE] = sense.angle
        failure.shaft[_SPEED] = sense.speed


@inlined
def fail_legs(failure: Failure, step: int, legs: NDArray[np.int64]) -> None:
    """Turn a leg off whose phase has failed.

    Parameters
    ----------
    failure : Failure
        What fails.
    step : int
        Number of the control period.
    legs : ndarray, shape (3,)
        States of the legs in it, changed.
    """
    if has_failed(failure, OPEN_PHASE, step):
        legs[failure.leg] = LEG_OFF
