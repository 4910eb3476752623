"""The constants of a drive, machine and inverter, for the compiled kernels (SI units)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine.emf import drive_fields


class Drive(NamedTuple):
    """Constants of a phase-decoupled machine on a split supply with one half-bridge leg per phase.

    Angles are electrical, speeds and torques are the shaft's. The back-EMF of a phase is
    ``emf_constant * speed * f(angle)`` with the shape f given by its corners.
    """

    resistance: float
    """Winding resistance (ohm)."""
    emf_constant: float
    """Peak back-EMF per shaft speed (V s/rad); also peak torque per ampere (N m/A)."""
    phases: int
    """Number of phases m; phase j lags phase j - 1 by pi/m electrical."""
    pole_pairs: int
    """Pole pairs p."""
    inductance: float
    """Winding inductance (H)."""
    half_supply_voltage: float
    """Nominal voltage of each half of the supply (V)."""
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


def make_drive(**values: Any) -> Drive:
    """Build the constants of a drive from the arguments of `drivegate_models.machine.emf.drive_fields`."""
    return Drive(**drive_fields(**values))


@inlined
def drifted(drive: Drive, resistance_factor: float, emf_factor: float) -> Drive:
    """Return a drive with windings and magnets at another temperature.

    `resistance_factor`, `emf_factor`: factors on the winding resistance and on the EMF constant (1).
    """
    # Compiled code has no `_replace`. The fields that drift are the first ones, so the rest is one slice.
    return Drive(drive.resistance * resistance_factor, drive.emf_constant * emf_factor, *drive[2:])
