"""A drive's numbers in the texts of checks of duty ratios, which name them."""

from __future__ import annotations

from drivegate.checks.number_words import milliseconds, percent
from drivegate.contracts.duty.document import duty_document
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.pm_ac.limits import DutyLimits, duty_limits_of


def numbers(drive: DriveDocument) -> dict[str, str]:
    """Write the numbers that checks of duty ratios tell, by the names that stand in their texts."""
    limits, rating = duty_limits_of(duty_document(drive)), drive.rating
    return {
        "base": f"{rating.base_speed_rpm:g} rpm",
        "current": f"{rating.current_limit_a:g} A",
        "k1": f"{limits.speed_tolerance_rpm:g} rpm",
        "torque_error": f"{limits.torque_error_nm:.4g} N·m",
        "weakening": percent(limits.weakening_share),
        "direct_error": f"{limits.direct_error_a:.4g} A",
        "peak": f"{limits.peak_current_a:.4g} A",
        "weakening_voltage": percent(limits.weakening_voltage),
        "braking": percent(limits.braking),
        "current_excess": percent(limits.current_excess),
        "loss_excess": percent(limits.loss_excess),
        "overshoot": percent(limits.overshoot),
        "coupling": percent(limits.coupled_current),
        "safe_time": _safe_time(limits),
        "failure_torque": f"{limits.failure_torque_nm:.4g} N·m",
        "dead_time_ripple": f"{limits.dead_time_ripple:g}",
        "modulation_ripple": f"{limits.modulation_ripple:g}",
        "rise": f"90 % within {milliseconds(limits.rise_time_s)} and what the voltage takes",
    }


def _safe_time(limits: DutyLimits) -> str:
    """Write the time to the safe state, and that with a locked rotor where it is another one."""
    every, locked = (f"{1000.0 * time:.4g} ms" for time in (limits.safe_state_s, limits.safe_state_locked_s))
    return every if every == locked else f"{every} ({locked} with a locked rotor)"
