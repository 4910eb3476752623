"""Transformations between the rotor frame, the stationary frame and the three phases."""

from __future__ import annotations

from math import pi, sqrt
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined, kernel
from drivegate_models.machine.sine import cosine_sine

HALF_ROOT: Final = 0.8660254037844386
"""Sine of a third of a turn."""
PER_ROOT_THREE: Final = 0.5 / HALF_ROOT
"""Peak phase voltage over peak line-to-line voltage (1)."""
_THIRD = 1.0 / 3.0
SUM_OVER_PEAK: Final = 6.0 / pi
"""Mean of the sum of three sinusoidal currents' magnitudes over their peak (1)."""
_COSINES: Final = (1.0, -0.5, -0.5)
_SINES: Final = (0.0, HALF_ROOT, -HALF_ROOT)


class RotorFrame(NamedTuple):
    """Currents in the rotor frame, and its electrical angle."""

    direct: float
    """d-axis current (A)."""
    quadrature: float
    """q-axis current (A)."""
    cosine: float
    """Cosine of the electrical angle (1)."""
    sine: float
    """Sine of the electrical angle (1)."""


@inlined
def axis_of(frame: RotorFrame, leg: int) -> tuple[float, float]:
    """Return cosine and sine of the angle from the axis of a phase to the d axis."""
    cosine = _COSINES[leg]
    sine = _SINES[leg]
    return frame.cosine * cosine + frame.sine * sine, frame.sine * cosine - frame.cosine * sine


@inlined
def phase_current(frame: RotorFrame, leg: int) -> float:
    """Return the current of a phase (A)."""
    cosine, sine = axis_of(frame, leg)
    return cosine * frame.direct - sine * frame.quadrature


@inlined
def turned(frame: RotorFrame, along: float, across: float) -> tuple[float, float]:
    """Return a d-q quantity in the stationary frame, along and across the first phase's axis."""
    return frame.cosine * along - frame.sine * across, frame.sine * along + frame.cosine * across


@inlined
def magnitude(along: float, across: float) -> float:
    """Return the magnitude of a quantity along and across an axis."""
    return sqrt(along * along + across * across)


@inlined
def from_phases(first: float, second: float, third: float) -> tuple[float, float]:
    """Return quantities of three phases in the stationary frame, without their mean (Clarke transformation)."""
    return (2.0 * first - second - third) * _THIRD, (second - third) * PER_ROOT_THREE


@inlined
def of_phase(leg: int, along: float, across: float) -> float:
    """Return the value of a phase for a quantity in the stationary frame."""
    if leg == 0:
        return along
    return -0.5 * along + (HALF_ROOT if leg == 1 else -HALF_ROOT) * across


@kernel
def phase_currents(
    direct: NDArray[np.float64], quadrature: NDArray[np.float64], angles: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the phase currents for currents in the rotor frame.

    `direct`, `quadrature`, shape (n,): d-axis and q-axis currents (A). `angles`, shape (n,): electrical angles of the d
    axis (rad). Result, shape (n, 3): currents of the three phases (A).
    """
    currents = np.empty((len(angles), 3))
    for row in range(len(angles)):
        cosine, sine = cosine_sine(angles[row])
        frame = RotorFrame(direct[row], quadrature[row], cosine, sine)
        for leg in range(3):
            currents[row, leg] = phase_current(frame, leg)
    return currents


@kernel
def rotor_currents(currents: NDArray[np.float64], angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the currents in the rotor frame for phase currents, without their mean.

    `currents`, shape (n, 3): phase currents (A). `angles`, shape (n,): electrical angles of the d axis (rad). Result,
    shape (n, 2): d-axis and q-axis currents (A).
    """
    found = np.empty((len(angles), 2))
    for row in range(len(angles)):
        cosine, sine = cosine_sine(angles[row])
        along, across = from_phases(currents[row, 0], currents[row, 1], currents[row, 2])
        found[row, 0] = cosine * along + sine * across
        found[row, 1] = cosine * across - sine * along
    return found


def shaft_angles(electrical: NDArray[np.float64], pole_pairs: int) -> NDArray[np.float64]:
    """Return the shaft's angles from the electrical angles of consecutive control periods.

    `electrical`, shape (n,): electrical angles of a run from its start, within one cycle (rad). Result, shape (n,):
    angles within one turn (rad).
    """
    return (np.unwrap(electrical) / pole_pairs) % (2.0 * np.pi)
