"""The machine on sinusoidal voltages: steady states in closed form, without the effects of switching.

Voltages and currents are the peak values of a phase's fundamental. A two-level bridge provides at most the link voltage
over the root of 3 without distortion, and 2/pi of the link voltage as the fundamental in six-step operation.
"""

from __future__ import annotations

from math import inf, pi, sqrt
from typing import Final, NamedTuple

from drivegate_models.compilation.kernels import inlined, kernel
from drivegate_models.pm_ac.plant.drive import PmAcDrive, electrical_torque

LINEAR_LIMIT: Final = 1.0 / sqrt(3.0)
"""Linear modulation limit: maximum undistorted peak phase voltage over link voltage (1)."""
SIX_STEPS: Final = 2.0 / pi
"""Fundamental of six-step operation over link voltage (1)."""


class SteadyState(NamedTuple):
    """A steady state on sinusoidal voltages."""

    direct: float
    """d-axis current (A)."""
    quadrature: float
    """q-axis current (A)."""
    torque: float
    """Electromagnetic torque (N m)."""
    current: float
    """Peak current of a phase (A)."""
    voltage: float
    """Peak voltage of a phase (V)."""
    copper_loss: float
    """Loss in the windings' resistance (W)."""
    core_loss: float
    """Loss in the core (W)."""

    @property
    def loss(self) -> float:
        """Copper and core loss (W)."""
        return self.copper_loss + self.core_loss


@inlined
def steady_voltages(
    drive: PmAcDrive, electrical: float, direct: float, quadrature: float
) -> tuple[float, float]:
    """Return the d-axis and q-axis voltages for steady currents.

    `electrical`: electrical speed (rad/s). `direct`, `quadrature`: currents of the rotor frame (A). Returns `direct`,
    `quadrature`: d-axis and q-axis voltages (V).
    """
    return (
        drive.resistance * direct - electrical * drive.quadrature_inductance * quadrature,
        drive.resistance * quadrature + electrical * (drive.direct_inductance * direct + drive.magnet_flux),
    )


@inlined
def core_loss(drive: PmAcDrive, electrical: float, direct: float, quadrature: float) -> float:
    """Return the core loss of steady currents.

    `electrical`: electrical speed (rad/s). `direct`, `quadrature`: currents of the rotor frame (A). Result: core loss
    from the voltage induced by the flux linkage (W).
    """
    along = electrical * (drive.direct_inductance * direct + drive.magnet_flux)
    across = electrical * drive.quadrature_inductance * quadrature
    return 1.5 * drive.core_loss_conductance * (along * along + across * across)


@kernel
def steady_state(drive: PmAcDrive, speed: float, direct: float, quadrature: float) -> SteadyState:
    """Return the steady state for currents in the rotor frame.

    `speed`: shaft speed (rad/s). `direct`, `quadrature`: currents of the rotor frame (A).
    """
    electrical = drive.pole_pairs * speed
    along, across = steady_voltages(drive, electrical, direct, quadrature)
    square = direct * direct + quadrature * quadrature
    return SteadyState(
        direct,
        quadrature,
        electrical_torque(drive, direct, quadrature),
        sqrt(square),
        sqrt(along * along + across * across),
        1.5 * drive.resistance * square,
        core_loss(drive, electrical, direct, quadrature),
    )


@inlined
def most_torque_per_ampere(drive: PmAcDrive, current: float) -> tuple[float, float]:
    """Return the currents of maximum torque at a magnitude (MTPA).

    ``i_d = (psi - sqrt(psi**2 + 8 dL**2 I**2)) / (4 dL)`` with ``dL = L_q - L_d``, written without the difference,
    which suffers cancellation in a machine with little saliency.

    `current`: peak current of a phase (A). Returns `direct`, `quadrature`: currents of the rotor frame (A); the torque
    is positive.
    """
    saliency = drive.quadrature_inductance - drive.direct_inductance
    square = current * current
    root = sqrt(drive.magnet_flux * drive.magnet_flux + 8.0 * saliency * saliency * square)
    divisor = abs(drive.magnet_flux) + root
    direct = 0.0
    if divisor > 0.0:
        direct = -2.0 * saliency * square / divisor
        if drive.magnet_flux < 0.0:
            direct = -direct
    quadrature = sqrt(max(square - direct * direct, 0.0))
    if electrical_torque(drive, direct, quadrature) < 0.0:
        quadrature = -quadrature
    return direct, quadrature


@kernel
def base_speed(drive: PmAcDrive, current: float, voltage: float) -> float:
    """Return the maximum speed at which a current produces its maximum torque within a voltage.

    The speed is the root of a quadratic equation: the voltage grows with the speed, because the torque is positive.

    `current`: peak current of a phase (A). `voltage`: peak voltage of a phase (V). Result: shaft speed (rad/s); 0 if
    the resistive drop exceeds the voltage.
    """
    direct, quadrature = most_torque_per_ampere(drive, current)
    along = drive.direct_inductance * direct + drive.magnet_flux
    across = drive.quadrature_inductance * quadrature
    square = along * along + across * across
    # |R i + j w psi|**2 = V**2, with the half of the mixed term.
    mixed = drive.resistance * (quadrature * along - direct * across)
    rest = drive.resistance * drive.resistance * current * current - voltage * voltage
    if rest >= 0.0 or square == 0.0:
        return 0.0 if rest >= 0.0 else inf
    return -rest / (mixed + sqrt(mixed * mixed - square * rest)) / drive.pole_pairs
