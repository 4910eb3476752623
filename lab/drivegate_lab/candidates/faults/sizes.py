"""How large a fault is on a drive: shares of what the drive is required to meet, is rated for, or takes.

A fault just beyond a tolerance has to be so on every drive: its size is a share of the drive's own quantities. Shares
are rounded like the numbers that people write, so that the texts of faults show them in full.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from math import frexp, ldexp, pi, radians
from typing import Any, Final, TypeAlias

from drivegate_cases.documents.wording import significant
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import limits_of, mechanical_time, nearest_step
from drivegate_models.units import RADIANS_PER_RPM

Quantity: TypeAlias = Callable[[DriveDocument], float]
"""Something of a drive, in the unit that people have for it."""

CONTROL_PERIOD: Final = 500e-6
"""Control period that sizes in steps are taken at (s)."""

_KEPT: Final = 200
# Of drawn speeds, as a share of base speed, so that a region of a few steps holds as many of them.
_SPEED_STEP: Final = 0.02
_INTO_SI: Final[dict[str, Callable[[float], float]]] = {
    "rpm": lambda value: value * RADIANS_PER_RPM,
    "°": radians,
    "° a rpm of error": lambda value: radians(value) / RADIANS_PER_RPM,
    # In the order of operations of the line of initial angles: bit for bit.
    "° a rpm": lambda value: radians(value) * 30.0 / pi,
}


@dataclass(frozen=True)
class Size:
    """A size that follows from the drive."""

    of: Quantity
    """Return it for a drive, in `unit`."""
    unit: str = ""
    """The unit in texts; empty for a plain number."""

    def number(self, drive: DriveDocument) -> float:
        """Return it as the controller takes it, in SI units."""
        return _INTO_SI.get(self.unit, float)(self.of(drive))

    def words(self, drive: DriveDocument) -> str:
        """Write it as in texts."""
        space = "" if not self.unit or self.unit.startswith("°") else " "
        return f"{self.of(drive):.6g}{space}{self.unit}"


def share(part: float, quantity: Size, digits: int = 3) -> Size:
    """Make a size that is a share of another one."""
    return Size(lambda drive: significant(part * quantity.of(drive), digits), quantity.unit)


def in_range(part: float, steps: float = 0.0) -> Size:
    """Make a speed by its share of the range from base speed to the highest, and steps of drawn speeds from there."""
    return Size(lambda drive: _on_grid(drive, BASE.of(drive), HIGHEST.of(drive), part, steps), "rpm")


def beyond_range(part: float) -> Size:
    """Make a speed by its share of the range from the highest to overspeed."""
    return Size(lambda drive: _on_grid(drive, HIGHEST.of(drive), OVERSPEED.of(drive), part, 0.0), "rpm")


def _on_grid(drive: DriveDocument, lowest: float, highest: float, part: float, steps: float) -> float:
    step = nearest_step(_SPEED_STEP * drive.rating.base_speed_rpm)
    whole = round((lowest + part * (highest - lowest)) / step)
    return round((whole + steps) * step, 9)


@lru_cache(maxsize=_KEPT)
def regulator(drive: DriveDocument) -> Any:
    """Return the constants that the reference has on a drive."""
    # It brings the compiler, which the names and kinds of faults do not need.
    import numpy as np

    from drivegate_models.contract.current.records import nameplate_record
    from drivegate_models.controllers.current.builtin import reset_function
    from drivegate_models.controllers.current.state import CONTROLLER_STATE, GUARDED

    state = np.zeros(1, CONTROLLER_STATE)
    reset_function()(state, nameplate_record(drive.nameplate(CONTROL_PERIOD)), GUARDED)
    return state[0]


def _pace(drive: DriveDocument) -> float:
    return float(regulator(drive)["paced_period"] / regulator(drive)["control_period"])


def _decision_period(drive: DriveDocument) -> float:
    return significant(CONTROL_PERIOD * float(regulator(drive)["decision_steps"]), 3)


def _inertia_current(drive: DriveDocument) -> float:
    machine = drive.machine
    conducting = float(regulator(drive)["conducting_phases"])
    return machine.inertia_kg_m2 / (conducting * machine.emf_constant_v_s_per_rad)


def power_of_two(quantity: Size) -> Size:
    """Make a size that is the least power of two above a quantity."""

    def of(drive: DriveDocument) -> float:
        return ldexp(1.0, frexp(quantity.of(drive))[1])

    return Size(of, quantity.unit)


K1: Final = Size(lambda drive: limits_of(drive).speed_tolerance_rpm, "rpm")
"""Greatest speed error of a search that has converged."""
K2: Final = Size(lambda drive: limits_of(drive).power_tolerance)
"""Greatest variation of the current sum, as a share of it."""
ANGLE_TOLERANCE: Final = Size(lambda drive: limits_of(drive).angle_tolerance_deg, "°")
"""Greatest movement of the advance angle."""
SETTLING: Final = Size(lambda drive: limits_of(drive).settling_s, "s")
"""Time in which a search has to converge."""
BASE: Final = Size(lambda drive: drive.rating.base_speed_rpm, "rpm")
"""Speed below which there is no advance."""
HIGHEST: Final = Size(lambda drive: drive.rating.highest_speed_rpm, "rpm")
"""Speed up to which rated power is required."""
OVERSPEED: Final = Size(lambda drive: drive.rating.overspeed_rpm, "rpm")
"""Greatest speed."""
CURRENT_LIMIT: Final = Size(lambda drive: drive.rating.current_limit_a, "A")
"""Greatest current reference."""
CONDUCTED: Final = Size(
    lambda drive: float(regulator(drive)["conducting_phases"]) * drive.rating.current_limit_a, "A"
)
"""Current sum of the phases that conduct at a time, at the current limit."""
ALL_PHASES: Final = Size(lambda drive: drive.machine.phases * drive.rating.current_limit_a, "A")
"""Current sum of all phases at the current limit."""
RATED_SUM: Final = Size(lambda drive: drive.rating.rated_power_w / drive.inverter.supply_voltage_v, "A")
"""Current sum that takes rated power from the supply."""
PHASES: Final = Size(lambda drive: float(drive.machine.phases))
"""Number of phases."""
MECHANICAL_TIME: Final = Size(mechanical_time, "s")
"""Time in which rated torque accelerates the shaft to base speed."""
PACE: Final = Size(_pace)
"""How much faster the reference regulates and decides than on the drive of the paper."""
DECISION_PERIOD: Final = Size(_decision_period, "s")
"""Time from one decision of the reference to the next."""
INERTIA_CURRENT: Final = Size(_inertia_current)
"""Current that accelerates the shaft, over the acceleration (A s²/rad)."""
INTEGRAL_OF_K1: Final = Size(lambda drive: float(regulator(drive)["integral_step"]) * K1.number(drive), "A")
"""What an error of k1 adds to the regulator's integral in a step."""


def per_pace(number: float, unit: str = "") -> Size:
    """Make a time that is so long at the pace of the paper's drive, and shorter where the reference is faster."""
    return Size(lambda drive: significant(number / _pace(drive), 3), unit)
