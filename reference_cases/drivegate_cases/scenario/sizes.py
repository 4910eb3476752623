"""How great speeds, torques and powers of a scenario may be, as follows from its drive."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Final

from drivegate_cases.drive.plant import Scales
from drivegate_cases.drive.rating import OVER_RATING, Rating
from drivegate_cases.scenario.load import ConstantPowerLoad, DynamometerLoad, Load, LockedLoad, VehicleLoad

# What a scenario of any drive may state, however small the drive.
_ANY_SPEED_RPM: Final = 1e6
_ANY_TORQUE_NM: Final = 1e6
_ANY_FRICTION_NM: Final = 1e5
_ANY_POWER_W: Final = 1e9


def check_sizes(
    rating: Rating, speeds_rpm: Iterable[tuple[str, float]], load: Load, scales: Scales, friction_nm: float
) -> None:
    """Refuse speeds, torques and powers that are beyond ten times the rating, and beyond what any drive may see."""
    torque = OVER_RATING * rating.rated_torque_nm
    found = [
        (key, speed, max(_ANY_SPEED_RPM, OVER_RATING * rating.overspeed_rpm), "rpm")
        for key, speed in speeds_rpm
    ]
    found += [(key, value, max(_ANY_TORQUE_NM, torque), "N·m") for key, value in _torques(load)]
    found += [
        ("scales.friction_added_n_m", scales.friction_added_n_m, max(_ANY_FRICTION_NM, torque), "N·m"),
        ("drift.friction_n_m", friction_nm, max(_ANY_FRICTION_NM, torque), "N·m"),
    ]
    if isinstance(load, ConstantPowerLoad):
        most = max(_ANY_POWER_W, OVER_RATING * rating.rated_power_w)
        found.append(("load.power_w", load.power_w, most, "W"))
    for key, value, most, unit in found:
        if abs(value) > most:
            what = "speeds" if unit == "rpm" else "values"
            raise ValueError(
                f"the key '{key}' is {value:g}, but must have {what} of at most {most:g} {unit} either way on "
                "this drive"
            )


def _torques(load: Load) -> Iterator[tuple[str, float]]:
    if isinstance(load, DynamometerLoad):
        yield from (("load.torque_reference_nm", torque) for _, torque in load.torque_reference_nm)
    elif not isinstance(load, (LockedLoad, ConstantPowerLoad, VehicleLoad)):
        yield "load.torque_nm", load.torque_nm
