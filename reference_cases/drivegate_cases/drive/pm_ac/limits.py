"""The limits of a PM AC drive with what follows from the drive itself."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import pi, sqrt
from typing import Final

from drivegate_cases.drive.limits import speed_tolerance_of
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_models.units import RADIANS_PER_RPM

FAILURE_SPEED_SHARE: Final = 0.2
"""Least speed at which something fails, over base speed: below, a phase takes too long to be missed (1)."""
SETTLING_PERIODS: Final = 8000
"""Control periods in which a steady state has to be reached, where no time is stated."""
_SAFE_PERIODS: Final = 1000
_SAFE_MOST_S: Final = 0.1
# What a detector needs: some control periods, and then half a turn of the field, or to see whether the shaft starts to
# turn: a share of the time in which rated torque accelerates it to base speed.
_DETECTION_PERIODS: Final = 100
_DETECTION_TURN: Final = 0.5
_DETECTION_RUN_UP: Final = 0.2
# Torque over the rated one that is left to turn a shaft past a sector of its Hall switches, where it starts under the
# heaviest load with an angle that is off by half a sector. Until then it looks like a locked one.
_LEFT: Final = 0.1
_SECTORS: Final = 6
_PERCENT: Final = 0.01
_MILLI: Final = 0.001
_SECONDS: Final = 60.0
_KEPT: Final = 100


@dataclass(frozen=True)
class DutyLimits:
    """What controllers of duty ratios are judged by."""

    settling_s: float
    """Time after a change from which on a steady state is judged (s)."""
    speed_tolerance_rpm: float
    """Greatest error k1 of the mean speed (rpm)."""
    rated_torque_nm: float
    """Torque of rated power at base speed (N·m), by which torques are measured."""
    torque_error_nm: float
    """Greatest error of the mean torque (N·m)."""
    overshoot: float
    """Greatest overshoot of the torque over the reference's step (1)."""
    coupling: float
    """Greatest movement of the d current over the q current's step (1)."""
    rise_time_s: float
    """Longest time of a torque step to 90 %, beside what the voltage takes to move the current (s)."""
    peak_a: float
    """Greatest phase current at any time (A)."""
    current_excess: float
    """Greatest excess of the current over the least one (1)."""
    loss_excess: float
    """Greatest excess of the loss over the least one (1)."""
    weakening: float
    """Least torque in weakening over the greatest that `weakening_voltage` allows (1)."""
    weakening_voltage: float
    """Voltage in weakening that a controller must use, over the undistorted one (1)."""
    direct_error_a: float
    """Greatest distance of the d current from that of most torque per ampere (A)."""
    braking: float
    """Greatest braking torque after a reference goes to zero, over the step, or over rated torque (1)."""
    safe_state_s: float
    """Longest time from a failure of the electronics or of a sensor to the safe state (s)."""
    safe_state_locked_s: float
    """The same from the time at which the rotor locks (s)."""
    failure_torque_nm: float
    """Greatest torque that nobody asks for until the safe state, and in it (N·m)."""
    dead_time_ripple: float
    """Greatest torque ripple with dead time over that without (1)."""
    modulation_ripple: float
    """Greatest torque ripple over that of ideal space-vector modulation (1)."""


@lru_cache(maxsize=_KEPT)
def duty_limits_of(drive: PmAcDocument) -> DutyLimits:
    """Return all limits of a drive; what its file leaves out follows from the drive."""
    stated, rating, machine = drive.requirements, drive.rating, drive.machine
    base = rating.base_speed_rpm * RADIANS_PER_RPM
    torque = rating.rated_power_w / base
    turns = machine.pole_pairs * rating.base_speed_rpm / _SECONDS
    run_up = machine.inertia_kg_m2 * base / torque
    settling = stated.settling_s
    return DutyLimits(
        settling_s=SETTLING_PERIODS * drive.inverter.control_period_s if settling is None else settling,
        speed_tolerance_rpm=speed_tolerance_of(drive),
        rated_torque_nm=torque,
        torque_error_nm=_PERCENT * stated.torque_tolerance_percent * torque,
        overshoot=_PERCENT * stated.overshoot_percent,
        coupling=_PERCENT * stated.coupled_current_percent,
        rise_time_s=stated.rise_periods * drive.inverter.control_period_s,
        peak_a=_PERCENT * stated.peak_current_percent * rating.current_limit_a,
        current_excess=_PERCENT * stated.least_current_percent,
        loss_excess=_PERCENT * stated.least_loss_percent,
        weakening=_PERCENT * stated.weakening_torque_percent,
        weakening_voltage=_PERCENT * stated.weakening_voltage_percent,
        direct_error_a=_PERCENT * stated.direct_current_percent * rating.current_limit_a,
        braking=_PERCENT * stated.braking_torque_percent,
        safe_state_s=_safe_state_s(drive, _DETECTION_TURN / (FAILURE_SPEED_SHARE * turns)),
        safe_state_locked_s=_safe_state_s(drive, _DETECTION_RUN_UP * run_up + _sector_s(drive, torque)),
        failure_torque_nm=_PERCENT * stated.failure_torque_percent * torque,
        dead_time_ripple=stated.dead_time_ripple,
        modulation_ripple=stated.modulation_ripple,
    )


def _sector_s(drive: PmAcDocument, torque: float) -> float:
    """Return how long a shaft that starts may show no edge of its Hall switches (s); 0 without such switches alone."""
    if drive.position != "hall":
        return 0.0
    sector = 2.0 * pi / (_SECTORS * drive.machine.pole_pairs)
    return sqrt(2.0 * sector * drive.machine.inertia_kg_m2 / (_LEFT * torque))


def _safe_state_s(drive: PmAcDocument, seen_s: float) -> float:
    """Return the longest time from a failure that shows after a time (s) to the safe state (s)."""
    stated, period = drive.requirements.safe_state_ms, drive.inverter.control_period_s
    if stated is not None:
        return _MILLI * stated
    return max(min(_SAFE_PERIODS * period, _SAFE_MOST_S), _DETECTION_PERIODS * period + seen_s)
