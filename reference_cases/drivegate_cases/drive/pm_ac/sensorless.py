"""What a PM AC drive without a position sensor must do at low speed, by what its machine and bridge permit."""

from __future__ import annotations

from math import pi, sqrt
from typing import Final

from drivegate_cases.drive.usual_values import DriveValues
from drivegate_models.units import RADIANS_PER_RPM

START_CURRENT: Final = 0.8
"""Current by which a shaft starts without a sensor, over the current limit (1)."""
START_TORQUE: Final = 0.5
"""Greatest load of a start without a sensor, over rated torque (1)."""
_LEAST_SHARE: Final = 0.05
# EMF over the fundamental of the error of dead time and drops, and torque that the resistance's error is stated for,
# over the rated one. A resistance that is 30 % off must cost 30 % of the EMF at most, so both are equal.
_OVER_DEAD_TIME: Final = 3.0
_LOADED: Final = 0.8
# A start: half as long along one direction and then along another, of natural periods up to a time (s), and a ramp at
# what a share of the pull-out torque leaves over the load, or at a share of it at least. Twice as long is allowed, and
# a time (s) for the observer.
_ALIGNED_PERIODS: Final = 4.0
_LONGEST_ALIGNED_S: Final = 0.5
_USED_TORQUE: Final = 0.8
_LEAST_USED: Final = 0.1
_ALLOWED: Final = 2.0
_OBSERVED_S: Final = 0.2
_HALVINGS: Final = 60


def least_speed_rpm(drive: DriveValues) -> float:
    """Return the speed from which on a controller without a sensor must run steadily (rpm).

    It is 5 % of base speed, or that at which the magnet's EMF is three times the error of the dead time and of the
    mean drop of switch and diode, or at which it equals the voltage across the resistance at 80 % of rated torque,
    whichever is greatest; and base speed at most.
    """
    machine, inverter, rating = drive.machine, drive.inverter, drive.rating
    dead = 4.0 / pi * inverter.lost_voltage_v
    resistive = machine.resistance_ohm * _current_of(drive, _LOADED * rating.rated_torque_nm)
    emf = max(_OVER_DEAD_TIME * dead, resistive)
    speed = emf / (machine.pole_pairs * machine.magnet_flux_v_s * RADIANS_PER_RPM)
    return float(min(max(_LEAST_SHARE * rating.base_speed_rpm, speed), rating.base_speed_rpm))


def natural_period_s(drive: DriveValues) -> float:
    """Return the period in which the rotor swings about the current of a start (s)."""
    machine = drive.machine
    stiffness = machine.pole_pairs * _pull_out_torque(drive)
    return float(2.0 * pi * sqrt(machine.inertia_kg_m2 / stiffness))


def start_time_s(drive: DriveValues, least_rpm: float) -> float:
    """Return the time from standstill to a speed (rpm) under half of rated torque (s)."""
    aligned = 1.5 * min(_ALIGNED_PERIODS * natural_period_s(drive), _LONGEST_ALIGNED_S)
    most = _pull_out_torque(drive)
    left = max(_USED_TORQUE * most - START_TORQUE * drive.rating.rated_torque_nm, _LEAST_USED * most)
    ramp = least_rpm * RADIANS_PER_RPM * drive.machine.inertia_kg_m2 / left
    return float(_ALLOWED * (aligned + ramp) + _OBSERVED_S)


def _pull_out_torque(drive: DriveValues) -> float:
    """Return the torque of a start's current across the magnet (N m)."""
    machine = drive.machine
    current = START_CURRENT * drive.rating.current_limit_a
    return float(1.5 * machine.pole_pairs * machine.magnet_flux_v_s * current)


def _current_of(drive: DriveValues, torque: float) -> float:
    """Return the least current of a torque (N m), at most the current limit (A), by bisection."""
    machine = drive.machine
    saliency, flux = machine.quadrature_inductance_h - machine.direct_inductance_h, machine.magnet_flux_v_s
    low, high = 0.0, float(drive.rating.current_limit_a)
    for _ in range(_HALVINGS):
        current = 0.5 * (low + high)
        turned = saliency * current
        root = sqrt(flux * flux + 8.0 * turned * turned)
        direct = -2.0 * saliency * current * current / (flux + root)
        quadrature = sqrt(max(current * current - direct * direct, 0.0))
        if 1.5 * machine.pole_pairs * (flux - saliency * direct) * quadrature < torque:
            low = current
        else:
            high = current
    return high
