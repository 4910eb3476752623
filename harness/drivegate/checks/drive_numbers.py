"""The numbers of a drive in the texts of checks, which stand there by name: ``k1 = {k1}``."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import Final

from drivegate.checks.check import Check
from drivegate.scenarios.drive_scale import scale_of, tidy
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import limits_of, mean_time
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.pm_ac.limits import DutyLimits, duty_limits_of
from drivegate_cases.scenario.sensors import has_encoder, real_sensors

TEXTS: Final = ("requirement", "limit", "scenarios", "formula", "why")
"""Texts of a check that have a drive's numbers in them."""
_KILO: Final = 1000.0
_KEPT: Final = 1_000
_SENSORS: Final = {
    "mcs96": "the sensors of the published implementation: encoder, Hall sensors, converter",
    "hall": "the sensors of conventional brushless DC drives: three Hall switches, current sensors, converter",
}


@lru_cache(maxsize=_KEPT)
def on_drive(check: Check, drive: DriveDocument) -> Check:
    """Write a drive's own numbers into the texts of a check."""
    numbers = duty_numbers(drive) if isinstance(drive, PmAcDocument) else drive_numbers(drive)
    return replace(check, **{name: getattr(check, name).format_map(numbers) for name in TEXTS})


def drive_numbers(drive: DriveDocument) -> dict[str, str]:
    """Write the numbers that checks tell, and what sensors the drive has, by the names that stand in their texts."""
    scale, limits, rating = scale_of(drive), limits_of(drive), drive.rating
    points = [f"{point.speed_rpm:g} rpm and {point.torque_n_m:g} N·m" for point in limits.points]
    return {
        "base": f"{rating.base_speed_rpm:g} rpm",
        "lowest": f"{scale.lowest_loaded_rpm:g}",
        "highest": f"{rating.highest_speed_rpm:g} rpm",
        "overspeed": f"{rating.overspeed_rpm:g} rpm",
        "power": _power(rating.rated_power_w),
        "current": f"{rating.current_limit_a:g} A",
        "k1": f"{limits.speed_tolerance_rpm:g} rpm",
        "k2": _percent(limits.power_tolerance),
        "angle": f"{limits.angle_tolerance_deg:g}°",
        "settling": f"{limits.settling_s:g} s",
        "stretch": f"{tidy(limits.settling_s + scale.shortest_window_s):g} s",
        "mean": f"{tidy(_KILO * mean_time(drive)):g} ms",
        "optimum": _percent(limits.optimum_tolerance),
        "ripple": _percent(limits.ripple),
        "closed_loop_ripple": _percent(limits.closed_loop_ripple),
        "points": " or ".join(points),
        "sensors": sensors_of(drive),
        **_disturbances(drive),
        "friction": f"{scale.friction_claimed_nm:g} N·m",
    }


def sensors_of(drive: DriveDocument) -> str:
    """Say what sensors a drive has."""
    return _SENSORS[real_sensors(drive).kind]


def _disturbances(drive: DriveDocument) -> dict[str, str]:
    """Name what can disturb the sensors and the plant that a drive has."""
    encoder = has_encoder(real_sensors(drive))
    return {
        "speed_sensor": "an encoder" if encoder else "Hall switches",
        "disturbed_sensors": "sensor dropouts and encoder glitches" if encoder else "sensor dropouts",
        "disturbed_plant": (
            "unequal halves of the supply and drifting parameters"
            if drive.has_split_supply
            else "drifting parameters"
        ),
    }


def duty_numbers(drive: PmAcDocument) -> dict[str, str]:
    """Write the numbers that checks of duty ratios tell, by the names that stand in their texts."""
    limits, rating = duty_limits_of(drive), drive.rating
    return {
        "base": f"{rating.base_speed_rpm:g} rpm",
        "current": f"{rating.current_limit_a:g} A",
        "k1": f"{limits.speed_tolerance_rpm:g} rpm",
        "torque_error": f"{limits.torque_error_nm:.4g} N·m",
        "weakening": _percent(limits.weakening_share),
        "direct_error": f"{limits.direct_error_a:.4g} A",
        "peak": f"{limits.peak_current_a:.4g} A",
        "weakening_voltage": _percent(limits.weakening_voltage),
        "braking": _percent(limits.braking),
        "current_excess": _percent(limits.current_excess),
        "loss_excess": _percent(limits.loss_excess),
        "overshoot": _percent(limits.overshoot),
        "coupling": _percent(limits.coupled_current),
        "safe_time": _safe_time(limits),
        "failure_torque": f"{limits.failure_torque_nm:.4g} N·m",
        "dead_time_ripple": f"{limits.dead_time_ripple:g}",
        "modulation_ripple": f"{limits.modulation_ripple:g}",
        "rise": f"90 % within {tidy(_KILO * limits.rise_time_s):g} ms and what the voltage takes",
    }


def _safe_time(limits: DutyLimits) -> str:
    """Write the time to the safe state, and that with a locked rotor where it is another one."""
    every, locked = (f"{_KILO * time:.4g} ms" for time in (limits.safe_state_s, limits.safe_state_locked_s))
    return every if every == locked else f"{every} ({locked} with a locked rotor)"


def _percent(share: float) -> str:
    if math.isinf(share):
        return "no limit"
    return f"{tidy(100.0 * share):g} %"


def _power(watts: float) -> str:
    return f"{watts / _KILO:g} kW" if watts >= _KILO else f"{watts:g} W"
