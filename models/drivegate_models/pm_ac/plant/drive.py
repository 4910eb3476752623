"""The constants of a PM AC drive, machine, bridge and modulator, as the compiled kernels take them (SI units)."""

from __future__ import annotations

from typing import Final, NamedTuple

from drivegate_models.compilation.kernels import inlined

CENTRED: Final = 0
"""The upper switch is on about the middle of the period: a symmetric carrier, one update in each of its periods."""
RISING: Final = 1
"""The upper switch is on at the end of the period: the first half of a symmetric carrier of two updates."""
FALLING: Final = 2
"""The upper switch is on at the start: the second half of such a carrier, or a sawtooth."""


class Modulator(NamedTuple):
    """How duty ratios become instants of switching."""

    updates: int = 1
    """Updates of the duty ratios in a period of the symmetric carrier: 1 or 2; 0 is a sawtooth of one update."""
    update_delay: int = 1
    """Control periods between the step that gives duty ratios and the period that they act in."""
    counter_levels: float = 0.0
    """Steps of the counter in a control period; 0 is no counter, but real numbers."""
    dead_time: float = 0.0
    """Time between the turn-off of a switch and the turn-on of the other one of its leg (s)."""
    minimum_pulse: float = 0.0
    """Pulses and gaps shorter than this are left out (s)."""


class PmAcDrive(NamedTuple):
    """Constants of a PM AC machine with an isolated neutral on a two-level bridge.

    Quantities of the rotor frame are peak values of a phase: an amplitude-invariant transformation. The direct axis
    is that of the magnet; the electrical angle goes from the axis of the first phase to it.
    """

    resistance: float
    """Winding resistance of a phase (ohm)."""
    magnet_flux: float
    """Peak flux linkage of a phase by the magnet (V s)."""
    direct_inductance: float
    """Inductance along the magnet's axis, L_d (H)."""
    quadrature_inductance: float
    """Inductance across it, L_q (H)."""
    pole_pairs: int
    """Pole pairs p."""
    link_voltage: float
    """Nominal voltage of the dc link (V)."""
    current_limit: float
    """Greatest peak current of a phase (A)."""
    modulator: Modulator = Modulator()
    """What switches the bridge."""
    core_loss_conductance: float = 0.0
    """Core loss a phase over the mean square of the voltage that the mean flux of a period induces (S)."""
    inertia: float = 1.0
    """Inertia of rotor and load (kg m2)."""
    friction: float = 0.0
    """Friction torque independent of speed (N m)."""
    viscous_friction: float = 0.0
    """Friction and windage torque a speed (N m s/rad)."""
    switch_drop: float = 0.0
    """Forward drop of a switch (V)."""
    diode_drop: float = 0.0
    """Forward drop of a freewheeling diode (V)."""
    turn_on_energy: float = 0.0
    """Energy lost at each turn-on of a switch that takes a current over (J)."""
    turn_off_energy: float = 0.0
    """Energy lost at each turn-off of a switch that carries a current (J)."""


def make_pm_ac_drive(*, pole_pairs: int, modulator: Modulator | None = None, **constants: float) -> PmAcDrive:
    """Build the constants of a drive from people's values, in SI units.

    Parameters
    ----------
    pole_pairs : int
        Number of pole pairs.
    modulator : Modulator, optional
        What switches the bridge; ideal switches, one update and a delay of one period where it is left out.
    **constants : float
        The other fields of `PmAcDrive`, by name and in its units; its defaults hold for those left out.

    Returns
    -------
    PmAcDrive
        The constants.
    """
    chosen = modulator or Modulator()
    # Each kernel is compiled for one type of drive; an int among the floats would compile it once more.
    return PmAcDrive(
        pole_pairs=int(pole_pairs),
        modulator=Modulator(
            int(chosen.updates),
            int(chosen.update_delay),
            float(chosen.counter_levels),
            float(chosen.dead_time),
            float(chosen.minimum_pulse),
        ),
        **{name: float(constant) for name, constant in constants.items()},
    )


@inlined
def drifted(drive: PmAcDrive, resistance_factor: float, emf_factor: float) -> PmAcDrive:
    """Return a drive whose windings and magnets have another temperature.

    Parameters
    ----------
    drive : PmAcDrive
        The drive.
    resistance_factor, emf_factor : float
        Factors on the winding resistance and on the magnet's flux (1).

    Returns
    -------
    PmAcDrive
        The same but for these two.
    """
    return PmAcDrive(drive.resistance * resistance_factor, drive.magnet_flux * emf_factor, *drive[2:])


@inlined
def electrical_torque(drive: PmAcDrive, direct: float, quadrature: float) -> float:
    """Return the electromagnetic torque of currents.

    Parameters
    ----------
    drive : PmAcDrive
        The drive.
    direct, quadrature : float
        Currents of the rotor frame (A).

    Returns
    -------
    float
        (N m).
    """
    saliency = drive.direct_inductance - drive.quadrature_inductance
    return 1.5 * drive.pole_pairs * (drive.magnet_flux + saliency * direct) * quadrature


@inlined
def alignment_of(updates: int, step: int) -> int:
    """Return where in a control period the upper switch is on.

    Parameters
    ----------
    updates : int
        Updates of the duty ratios in a period of the carrier, as `Modulator` has them.
    step : int
        Number of the control period.

    Returns
    -------
    int
        `CENTRED`, `RISING` or `FALLING`.
    """
    if updates == 0:
        return FALLING
    if updates == 1:
        return CENTRED
    return RISING if step % 2 == 0 else FALLING
