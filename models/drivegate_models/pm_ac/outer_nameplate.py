"""The nameplate of a PM AC drive with an inner loop, for a controller of current reference and advance angle."""

from __future__ import annotations

from math import isfinite, pi, sqrt

from drivegate_models.contract.current.signals import PM_AC, Nameplate
from drivegate_models.contract.duty.signals import DutyNameplate
from drivegate_models.machine.sine import cosine_sine
from drivegate_models.pm_ac.oracle import CURRENT, least_at, undistorted_limits
from drivegate_models.pm_ac.plant.drive import PmAcDrive, make_pm_ac_drive

_STEPS = 8
# Shares of the undistorted voltage; the rest is reserved for the current regulators.
_VOLTAGE_SHARES = (0.95, 1.0)


def _advance_angle(direct: float, quadrature: float) -> float:
    """Return the angle b (rad) of currents ``-I sin b`` and ``I cos b``, rounded identically on every processor."""
    current = sqrt(direct * direct + quadrature * quadrature)
    if current == 0.0:
        return 0.0
    angle = 0.25 * pi
    for _ in range(_STEPS):
        cosine, sine = cosine_sine(angle)
        # The correction is the sine of the remaining angle, with an error of a sixth of its cube.
        angle -= (direct * cosine + quadrature * sine) / current
    return angle


def outer_nameplate(nameplate: DutyNameplate, periods: int) -> Nameplate:
    """Return the nominal data of a drive in the contract of current references.

    `periods`: control periods of the drive per step of the outer controller. Result: the line of advance angles
    connects the angles of minimum current for rated power at base speed and at the highest speed, with a voltage
    reserve of 5 % if the drive has it. Windows are those of a sine, whose torque per ampere is half that of three
    phases that conduct all the time.
    """
    drive = make_pm_ac_drive(
        pole_pairs=nameplate.pole_pairs,
        resistance=nameplate.resistance,
        magnet_flux=nameplate.magnet_flux,
        direct_inductance=nameplate.direct_inductance,
        quadrature_inductance=nameplate.quadrature_inductance,
        link_voltage=nameplate.supply_voltage,
        current_limit=nameplate.current_limit,
        core_loss_conductance=nameplate.core_loss_conductance,
        inertia=nameplate.inertia,
    )
    base_speed, highest_speed = nameplate.base_speed, nameplate.highest_speed
    start, end = (_minimum_current_angle(drive, nameplate, speed) for speed in (base_speed, highest_speed))
    return Nameplate(
        phases=3,
        pole_pairs=drive.pole_pairs,
        half_supply_voltage=0.5 * drive.link_voltage,
        base_speed=base_speed,
        rated_power=nameplate.rated_power,
        current_limit=drive.current_limit,
        control_period=periods * nameplate.control_period,
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


def _minimum_current_angle(drive: PmAcDrive, nameplate: DutyNameplate, speed: float) -> float:
    """Return the angle of minimum current at rated power (rad), with a voltage reserve if the drive has it."""
    torque = nameplate.rated_power / speed
    for share in _VOLTAGE_SHARES:
        limits = undistorted_limits(drive, share * drive.link_voltage)
        state = least_at(drive, limits, speed, torque, CURRENT)
        if isfinite(state.direct):
            break
    return _advance_angle(state.direct, state.quadrature) if isfinite(state.direct) else 0.0
