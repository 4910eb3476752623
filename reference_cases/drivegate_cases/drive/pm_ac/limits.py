"""The limits of a PM AC drive with what follows from the drive itself."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

from drivegate_cases.drive.limits import speed_tolerance_of
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_models.units import RADIANS_PER_RPM

SETTLING_PERIODS: Final = 8000
"""Control periods in which a steady state has to be reached, where no time is stated."""
_PERCENT: Final = 0.01
_MILLI: Final = 0.001
_KEPT: Final = 100


@dataclass(frozen=True)
class DutyLimits:
    """What controllers of duty ratios are judged by.

    Attributes
    ----------
    settling_s : float
        Time after a change from which on a steady state is judged (s).
    speed_tolerance_rpm : float
        Greatest error k1 of the mean speed (rpm).
    rated_torque_nm : float
        Torque of rated power at base speed (N·m), by which torques are measured.
    torque_error_nm : float
        Greatest error of the mean torque (N·m).
    overshoot : float
        Greatest overshoot of the torque over the reference's step (1).
    coupled_current : float
        Greatest movement of the d current over the q current's step (1).
    rise_time_s : float
        Longest time of a torque step to 90 %, beside what the voltage takes to move the current (s).
    peak_current_a : float
        Greatest phase current at any time (A).
    current_excess : float
        Greatest excess of the current over the least one (1).
    loss_excess : float
        Greatest excess of the loss over the least one (1).
    weakening_share : float
        Least torque in weakening over the greatest possible (1).
    direct_error_a : float
        Greatest distance of the d current from that of most torque per ampere (A).
    braking_torque_nm : float
        Greatest braking torque behind a reference that goes to zero (N·m).
    safe_state_s : float
        Longest time from a failure to the safe state (s).
    failure_torque_nm : float
        Greatest torque that nobody asks for until the safe state, and in it (N·m).
    dead_time_ripple : float
        Greatest torque ripple with dead time over that without (1).
    modulation_ripple : float
        Greatest torque ripple over that of ideal space-vector modulation (1).
    """

    settling_s: float
    speed_tolerance_rpm: float
    rated_torque_nm: float
    torque_error_nm: float
    overshoot: float
    coupled_current: float
    rise_time_s: float
    peak_current_a: float
    current_excess: float
    loss_excess: float
    weakening_share: float
    direct_error_a: float
    braking_torque_nm: float
    safe_state_s: float
    failure_torque_nm: float
    dead_time_ripple: float
    modulation_ripple: float


@lru_cache(maxsize=_KEPT)
def duty_limits_of(drive: PmAcDocument) -> DutyLimits:
    """Give the limits of a drive; what its file leaves out follows from the drive.

    Parameters
    ----------
    drive : PmAcDocument
        The drive.

    Returns
    -------
    DutyLimits
        All of them.
    """
    stated, rating = drive.requirements, drive.rating
    torque = rating.rated_power_w / (rating.base_speed_rpm * RADIANS_PER_RPM)
    settling = stated.settling_s
    return DutyLimits(
        settling_s=SETTLING_PERIODS * drive.inverter.control_period_s if settling is None else settling,
        speed_tolerance_rpm=speed_tolerance_of(drive),
        rated_torque_nm=torque,
        torque_error_nm=_PERCENT * stated.torque_tolerance_percent * torque,
        overshoot=_PERCENT * stated.overshoot_percent,
        coupled_current=_PERCENT * stated.coupled_current_percent,
        rise_time_s=stated.rise_periods * drive.inverter.control_period_s,
        peak_current_a=_PERCENT * stated.peak_current_percent * rating.current_limit_a,
        current_excess=_PERCENT * stated.least_current_percent,
        loss_excess=_PERCENT * stated.least_loss_percent,
        weakening_share=_PERCENT * stated.weakening_torque_percent,
        direct_error_a=_PERCENT * stated.direct_current_percent * rating.current_limit_a,
        braking_torque_nm=_PERCENT * stated.braking_torque_percent * torque,
        safe_state_s=_MILLI * stated.safe_state_ms,
        failure_torque_nm=_PERCENT * stated.failure_torque_percent * torque,
        dead_time_ripple=stated.dead_time_ripple,
        modulation_ripple=stated.modulation_ripple,
    )
