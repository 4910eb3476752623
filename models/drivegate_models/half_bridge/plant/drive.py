"""The constants of one drive, machine and inverter, as the compiled kernels take them (SI units)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine.emf import full_cycle


class Drive(NamedTuple):
    """Constants of a phase-decoupled machine on a split supply with one half-bridge leg a phase.

    Angles are electrical, speeds and torques are the shaft's. The back-EMF of a phase is
    ``emf_constant * speed * f(angle)`` with the shape f given by its corners.
    """

    phases: int
    """Number of phases m; phase j lags phase j - 1 by pi/m electrical."""
    pole_pairs: int
    """Pole pairs p."""
    resistance: float
    """Winding resistance (ohm)."""
    inductance: float
    """Winding inductance (H)."""
    emf_constant: float
    """Peak back-EMF a shaft speed (V s/rad); also peak torque an ampere (N m/A)."""
    half_supply_voltage: float
    """Nominal voltage of each half of the supply (V)."""
    hysteresis_band: float
    """Half-width h of the current band (A); 0 is the ideal regulator."""
    window: float
    """Width of each conduction window (rad electrical)."""
    current_limit: float
    """Greatest current reference (A)."""
    core_loss_conductance: float
    """Core loss a phase over the square of the gap voltage (S)."""
    inertia: float
    """Inertia of rotor and load (kg m2)."""
    friction: float
    """Friction torque independent of speed (N m)."""
    viscous_friction: float
    """Friction and windage torque a speed (N m s/rad)."""
    switch_drop: float
    """Forward drop of a switch (V)."""
    diode_drop: float
    """Forward drop of a freewheeling diode (V)."""
    turn_on_energy: float
    """Energy lost at each turn-on of a switch (J)."""
    turn_off_energy: float
    """Energy lost at each turn-off of a switch (J)."""
    emf_angles: NDArray[np.float64]
    """Corners of the back-EMF shape, shape (k + 1,), from 0 to 2 pi (rad electrical)."""
    emf_values: NDArray[np.float64]
    """Shape at the corners, shape (k + 1,) (1)."""
    emf_slopes: NDArray[np.float64]
    """Slope of the shape after each corner, shape (k,) (1/rad)."""


def make_drive(
    *,
    phases: int,
    pole_pairs: int,
    resistance: float,
    inductance: float,
    emf_constant: float,
    emf_angles: NDArray[np.float64],
    emf_values: NDArray[np.float64],
    half_supply_voltage: float,
    hysteresis_band: float,
    window: float,
    current_limit: float,
    core_loss_conductance: float = 0.0,
    inertia: float = 1.0,
    friction: float = 0.0,
    viscous_friction: float = 0.0,
    switch_drop: float = 0.0,
    diode_drop: float = 0.0,
    turn_on_energy: float = 0.0,
    turn_off_energy: float = 0.0,
) -> Drive:
    """Build the constants of a drive from people's values, in SI units.

    Parameters
    ----------
    phases, pole_pairs : int
        Number of phases and of pole pairs.
    resistance, inductance : float
        Of one winding (ohm, H).
    emf_constant : float
        Peak back-EMF of a phase a shaft speed (V s/rad).
    emf_angles, emf_values : ndarray, shape (k,)
        Corners of the positive half cycle of the back-EMF shape (rad, 1); see `drivegate_models.machine.emf`.
    half_supply_voltage : float
        Voltage of each half of the supply (V).
    hysteresis_band : float
        Half-width of the current band (A).
    window : float
        Width of each conduction window (rad electrical).
    current_limit : float
        Greatest current reference (A).
    core_loss_conductance : float
        Core loss conductance a phase (S).
    inertia : float
        Inertia (kg m2).
    friction, viscous_friction : float
        Friction torque (N m) and its part a speed (N m s/rad).
    switch_drop, diode_drop : float
        Forward drops (V).
    turn_on_energy, turn_off_energy : float
        Losses of each switching (J).

    Returns
    -------
    Drive
        The constants, with the shape's corners over the whole cycle.
    """
    angles, values = full_cycle(emf_angles, emf_values)
    return Drive(
        phases=int(phases),
        pole_pairs=int(pole_pairs),
        resistance=float(resistance),
        inductance=float(inductance),
        emf_constant=float(emf_constant),
        half_supply_voltage=float(half_supply_voltage),
        hysteresis_band=float(hysteresis_band),
        window=float(window),
        current_limit=float(current_limit),
        core_loss_conductance=float(core_loss_conductance),
        inertia=float(inertia),
        friction=float(friction),
        viscous_friction=float(viscous_friction),
        switch_drop=float(switch_drop),
        diode_drop=float(diode_drop),
        turn_on_energy=float(turn_on_energy),
        turn_off_energy=float(turn_off_energy),
        emf_angles=angles,
        emf_values=values,
        emf_slopes=np.diff(values) / np.diff(angles),
    )


@inlined
def drifted(drive: Drive, resistance_factor: float, emf_factor: float) -> Drive:
    """Return a drive whose windings and magnets have another temperature.

    Parameters
    ----------
    drive : Drive
        The drive.
    resistance_factor, emf_factor : float
        Factors on the winding resistance and on the EMF constant (1).

    Returns
    -------
    Drive
        The same but for these two.
    """
    return Drive(
        drive.phases,
        drive.pole_pairs,
        drive.resistance * resistance_factor,
        drive.inductance,
        drive.emf_constant * emf_factor,
        drive.half_supply_voltage,
        drive.hysteresis_band,
        drive.window,
        drive.current_limit,
        drive.core_loss_conductance,
        drive.inertia,
        drive.friction,
        drive.viscous_friction,
        drive.switch_drop,
        drive.diode_drop,
        drive.turn_on_energy,
        drive.turn_off_energy,
        drive.emf_angles,
        drive.emf_values,
        drive.emf_slopes,
    )
