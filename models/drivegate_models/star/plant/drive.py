"""The constants of a star-connected drive, machine and inverter, for the compiled kernels (SI units)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine.emf import drive_fields

EVERY_HALF: Final = 0b1111
"""Every phase chops throughout its windows, each with its own comparator."""
UPPER_ONLY: Final = 0b0011
"""Only the upper switches chop; the lower ones are on throughout the negative windows."""
PWM_ON: Final = 0b0101
"""A phase chops in the first half of each window and is on in the second."""
ON_PWM: Final = 0b1010
"""A phase is on in the first half of each window and chops in the second."""
REGULATIONS: Final[Mapping[str, int]] = {
    "every-half": EVERY_HALF,
    "upper-only": UPPER_ONLY,
    "pwm-on": PWM_ON,
    "on-pwm": ON_PWM,
}
"""The chopping halves of each scheme."""


class StarDrive(NamedTuple):
    """Constants of a star-connected machine with an isolated neutral on one half-bridge leg per phase.

    Angles are electrical, speeds and torques are the shaft's. The back-EMF of a phase is
    ``emf_constant * speed * f(angle)`` with the shape f given by its corners.
    """

    resistance: float
    """Winding resistance of a phase (ohm)."""
    emf_constant: float
    """Peak back-EMF of a phase per shaft speed (V s/rad); also peak torque per ampere (N m/A)."""
    phases: int
    """Number of phases m, odd and at least 3; phase j lags phase j - 1 by 2 pi/m electrical."""
    pole_pairs: int
    """Pole pairs p."""
    inductance: float
    """Self minus mutual inductance of a phase (H)."""
    half_supply_voltage: float
    """Half of the link's nominal voltage (V)."""
    hysteresis_band: float
    """Half-width h of the current band (A); 0 is the ideal regulator."""
    window: float
    """Width of each conduction window (rad electrical)."""
    current_limit: float
    """Maximum current reference (A)."""
    emf_angles: NDArray[np.float64]
    """Corners of the back-EMF shape, shape (k + 1,), from 0 to 2 pi (rad electrical)."""
    emf_values: NDArray[np.float64]
    """Shape at the corners, shape (k + 1,) (1)."""
    emf_slopes: NDArray[np.float64]
    """Slope of the shape after each corner, shape (k,) (1/rad)."""
    regulation: int = EVERY_HALF
    """Which halves of the windows chop, one bit each: positive first and second, negative first and second."""
    core_loss_conductance: float = 0.0
    """Core loss of a phase over the square of the gap voltage (S)."""
    inertia: float = 1.0
    """Inertia of rotor and load (kg m2)."""
    friction: float = 0.0
    """Friction torque independent of speed (N m)."""
    viscous_friction: float = 0.0
    """Friction and windage torque per shaft speed (N m s/rad)."""
    switch_drop: float = 0.0
    """Forward drop of a switch (V)."""
    diode_drop: float = 0.0
    """Forward drop of a freewheeling diode (V)."""
    turn_on_energy: float = 0.0
    """Energy lost at each turn-on of a switch (J)."""
    turn_off_energy: float = 0.0
    """Energy lost at each turn-off of a switch (J)."""


def make_star_drive(*, regulation: int = EVERY_HALF, **values: Any) -> StarDrive:
    """Build the constants of a drive from the halves of the windows that chop, and the arguments of `drive_fields`."""
    return StarDrive(regulation=int(regulation), **drive_fields(**values))


@inlined
def drifted(drive: StarDrive, resistance_factor: float, emf_factor: float) -> StarDrive:
    """Return a drive with windings and magnets at another temperature.

    `resistance_factor`, `emf_factor`: factors on the winding resistance and on the EMF constant (1).
    """
    return StarDrive(drive.resistance * resistance_factor, drive.emf_constant * emf_factor, *drive[2:])
