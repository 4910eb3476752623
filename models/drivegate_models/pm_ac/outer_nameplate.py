"""What a controller of current reference and advance angle is told of a PM AC drive behind an inner loop."""

from __future__ import annotations

from math import pi, sqrt

from drivegate_models.contract.outer_loop.signals import PM_AC, Nameplate
from drivegate_models.machine.sine import cosine_sine
from drivegate_models.pm_ac.oracle import CURRENT, Limits, least_at
from drivegate_models.pm_ac.plant.drive import PmAcDrive

_STEPS = 8


def _advance_angle(direct: float, quadrature: float) -> float:
    """Return the angle b (rad) of currents ``-I sin b`` and ``I cos b``, by operations rounded alike anywhere."""
    current = sqrt(direct * direct + quadrature * quadrature)
    if current == 0.0:
        return 0.0
    angle = 0.25 * pi
    for _ in range(_STEPS):
        cosine, sine = cosine_sine(angle)
        # The sine of what is missing, which leaves a sixth of its cube.
        angle -= (direct * cosine + quadrature * sine) / current
    return angle


def outer_nameplate(
    drive: PmAcDrive,
    limits: Limits,
    *,
    rated_power: float,
    base_speed: float,
    highest_speed: float,
    control_period: float,
) -> Nameplate:
    """Tell the nominal data of a drive in the contract of current references.

    Parameters
    ----------
    drive : PmAcDrive
        The drive.
    limits : Limits
        Of current and voltage that rated power is reached within.
    rated_power : float
        Mechanical (W).
    base_speed, highest_speed : float
        Range of constant power (rad/s).
    control_period : float
        Time from one step of the outer controller to the next (s).

    Returns
    -------
    Nameplate
        The line of advance angles leads from that of least current at rated power and base speed to that at the
        highest speed. Windows are those of a sine, whose torque an ampere is half that of three phases that conduct
        all the time.
    """
    start, end = (
        _advance_angle(state.direct, state.quadrature)
        for state in (
            least_at(drive, limits, base_speed, rated_power / base_speed, CURRENT),
            least_at(drive, limits, highest_speed, rated_power / highest_speed, CURRENT),
        )
    )
    return Nameplate(
        phases=3,
        pole_pairs=drive.pole_pairs,
        half_supply_voltage=0.5 * drive.link_voltage,
        base_speed=base_speed,
        rated_power=rated_power,
        current_limit=drive.current_limit,
        control_period=control_period,
        hysteresis_band=0.0,
        resistance=drive.resistance,
        inductance=0.5 * (drive.direct_inductance + drive.quadrature_inductance),
        emf_constant=drive.pole_pairs * drive.magnet_flux,
        inertia=drive.inertia,
        kind=PM_AC,
        window=pi,
        conducting_phases=1.5,
        advance_start=start,
        advance_slope=(end - start) / (highest_speed - base_speed),
        highest_speed=highest_speed,
    )
