"""The constants of a PM AC drive, machine, bridge and modulator, for the compiled kernels (SI units)."""

from __future__ import annotations

from typing import Final, NamedTuple

from drivegate_models.compilation.kernels import inlined
from drivegate_models.pm_ac.plant.dc_link import DcLink

CENTRED: Final = 0
"""The upper switch is on around the middle of the period: a symmetric carrier with one update per carrier period."""
RISING: Final = 1
"""The upper switch is on at the end of the period: the first half of a symmetric carrier with two updates."""
FALLING: Final = 2
"""The upper switch is on at the start of the period: the second half of that carrier, or a sawtooth carrier."""


class Modulator(NamedTuple):
    """Conversion of duty ratios to instants of switching."""

    updates: int = 1
    """Updates of the duty ratios per period of the symmetric carrier: 1 or 2; 0 is a sawtooth with one update."""
    update_delay: int = 1
    """Control periods between the step that commands duty ratios and the period in which they act."""
    counter_levels: float = 0.0
    """Steps of a duty ratio from 0 to 1; 0 for no quantization. They are the counts of the modulator in half a period
    of a symmetric carrier, with one update or two, or in a period of a sawtooth: edges lie on the counts."""
    dead_time: float = 0.0
    """Time between the turn-off of a switch and the turn-on of the other one of its leg (s)."""
    minimum_pulse: float = 0.0
    """Minimum length of pulses and gaps; shorter ones are omitted (s)."""
    control_every: int = 1
    """Carrier periods in a control period, in which the duty ratios hold; 1 with two updates per carrier period."""


class PmAcDrive(NamedTuple):
    """Constants of a PM AC machine with an isolated neutral on a two-level bridge.

    Quantities in the rotor frame are peak values of a phase: the transformation is amplitude-invariant. The d axis
    is the magnet's axis. The electrical angle is from the axis of the first phase to the d axis.
    """

    resistance: float
    """Winding resistance of a phase (ohm)."""
    magnet_flux: float
    """Peak flux linkage of a phase by the magnet (V s)."""
    direct_inductance: float
    """d-axis inductance L_d (H)."""
    quadrature_inductance: float
    """q-axis inductance L_q (H)."""
    pole_pairs: int
    """Pole pairs p."""
    link_voltage: float
    """Nominal voltage of the dc link (V)."""
    current_limit: float
    """Maximum peak current of a phase (A)."""
    modulator: Modulator = Modulator()
    """Carrier, delay, counter, dead time and minimum pulse."""
    core_loss_conductance: float = 0.0
    """Core loss of a phase over the mean square of the voltage induced by the period's mean flux (S)."""
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
    """Energy lost at each turn-on of a switch that takes a current over (J)."""
    turn_off_energy: float = 0.0
    """Energy lost at each turn-off of a switch that carries a current (J)."""
    dc_link: DcLink = DcLink()
    """Capacitor and source of the dc link; ideal by default."""


def make_pm_ac_drive(
    *, pole_pairs: int, modulator: Modulator | None = None, dc_link: DcLink | None = None, **constants: float
) -> PmAcDrive:
    """Build the constants of a drive from values in SI units.

    `modulator`: by default ideal switches, one update and a delay of one period. `dc_link`: by default ideal.
    `constants`: the other fields of `PmAcDrive`, in its units; missing ones have its defaults. Result: with ints and
    floats of the types that the kernels are compiled for.
    """
    chosen = modulator or Modulator()
    # Each kernel is compiled for one type of drive; an int instead of a float would compile it a second time.
    return PmAcDrive(
        pole_pairs=int(pole_pairs),
        modulator=Modulator(
            int(chosen.updates),
            int(chosen.update_delay),
            float(chosen.counter_levels),
            float(chosen.dead_time),
            float(chosen.minimum_pulse),
            int(chosen.control_every),
        ),
        dc_link=dc_link or DcLink(),
        **{name: float(constant) for name, constant in constants.items()},
    )


@inlined
def drifted(drive: PmAcDrive, resistance_factor: float, emf_factor: float) -> PmAcDrive:
    """Return a drive with windings and magnets at another temperature.

    `resistance_factor`, `emf_factor`: factors on the winding resistance and on the magnet's flux (1).
    """
    return PmAcDrive(drive.resistance * resistance_factor, drive.magnet_flux * emf_factor, *drive[2:])


@inlined
def electrical_torque(drive: PmAcDrive, direct: float, quadrature: float) -> float:
    """Return the electromagnetic torque (N m) of d-axis and q-axis currents (A)."""
    saliency = drive.direct_inductance - drive.quadrature_inductance
    return 1.5 * drive.pole_pairs * (drive.magnet_flux + saliency * direct) * quadrature


@inlined
def alignment_of(updates: int, step: int) -> int:
    """Return the alignment of the upper switch's pulse in a control period.

    `updates`: updates of the duty ratios per carrier period, as in `Modulator`. Result: `CENTRED`, `RISING` or
    `FALLING`.
    """
    if updates == 0:
        return FALLING
    if updates == 1:
        return CENTRED
    return RISING if step % 2 == 0 else FALLING
