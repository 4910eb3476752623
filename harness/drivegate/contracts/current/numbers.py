"""A drive's numbers in the texts of checks, which name them (``k1 = {k1}``), and feasible angles in words."""

from __future__ import annotations

from typing import Final

from drivegate.candidates.declaration import Declaration
from drivegate.checks.number_words import limit_words, milliseconds, power
from drivegate.scenarios.drive_scale import scale_of, tidy
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import limits_of, mean_time
from drivegate_cases.drive.requirements import points_of
from drivegate_cases.scenario.sensors import has_encoder, real_sensors

FEASIBLE: Final = (
    "An angle is feasible where it gives the torque with the current reference at its limit too. At another one a "
    "smaller reference may give it, even with Σ|i| below the least of the feasible angles, but a regulator at its "
    "limit may lose it."
)
"""What feasible means, and why Σ|i| may lie below the least."""
_SENSORS: Final = {
    "mcs96": "the sensors of the published implementation: encoder, Hall sensors, converter",
    "hall": "the sensors of conventional brushless DC drives: three Hall switches, current sensors, converter",
}


def given_below_limit(reference: float) -> str:
    """State what is lost where a current reference gives a torque, and the limit does not (A)."""
    return f"{reference:.3g} A gives the torque, but a regulator at its limit may lose it"


def numbers(drive: DriveDocument, _declaration: Declaration) -> dict[str, str]:
    """Write the numbers that checks state, and what sensors the drive has, by the names that stand in their texts."""
    scale, rating = scale_of(drive), drive.rating
    encoder = has_encoder(real_sensors(drive), drive)
    points = [f"{point.speed_rpm:g} rpm and {point.torque_n_m:g} N·m" for point in points_of(drive)]
    return limit_words(drive) | {
        "base": f"{rating.base_speed_rpm:g} rpm",
        "lowest": f"{scale.lowest_loaded_rpm:g}",
        "highest": f"{rating.highest_speed_rpm:g} rpm",
        "overspeed": f"{rating.overspeed_rpm:g} rpm",
        "power": power(rating.rated_power_w),
        "current": f"{rating.current_limit_a:g} A",
        "stretch": f"{tidy(limits_of(drive).settling_s + scale.shortest_window_s):g} s",
        "mean": milliseconds(mean_time(drive)),
        "points": " or ".join(points),
        "sensors": sensors_of(drive),
        "speed_sensor": "an encoder" if encoder else "Hall switches",
        "disturbed_sensors": "sensor dropouts and encoder glitches" if encoder else "sensor dropouts",
        "disturbed_plant": (
            "unequal halves of the supply and drifting parameters"
            if drive.has_split_supply
            else "drifting parameters"
        ),
        "friction": f"{scale.friction_claimed_nm:g} N·m",
    }


def sensors_of(drive: DriveDocument) -> str:
    return _SENSORS[real_sensors(drive).kind]
