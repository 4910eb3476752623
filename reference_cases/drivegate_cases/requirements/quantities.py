"""The quantities that a row can limit: every signal that a contract declares, and what follows from its signals."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import pi
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import mechanical_time

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Columns: TypeAlias = "Mapping[str, NDArray[np.float64]]"
"""Signals of a run by name, each of shape (n,), one value for each control period, in the unit of the name."""
Compute: TypeAlias = "Callable[[Columns, DriveDocument], NDArray[np.float64]]"
"""From signals and a drive to a quantity, shape (n,)."""
Scale: TypeAlias = Callable[[DriveDocument], float]
"""From a drive to the size that a quantity has at its rating."""
_PERCENT: Final = 100.0
_HALVES: Final = 2.0


@dataclass(frozen=True)
class Quantity:
    """A quantity over a run, named with its unit."""

    name: str
    words: str
    """What messages call it."""
    unit: str
    columns: tuple[str, ...]
    """Signals that it follows from; a contract without one of them does not have the quantity."""
    compute: Compute
    scale: Scale
    follows: Literal["speed", "torque", ""] = ""
    """The reference without which it means nothing: that of a run in which the controller follows it."""
    shown: str = ""
    """Signal that figures show for it; empty where none does."""
    around: str = ""
    """Signal that the shown one is meant to follow, about which a figure draws the limits; empty for zero."""
    remark: str = ""
    """What the words leave open."""


def speed_scale(drive: DriveDocument) -> float:
    return drive.rating.highest_speed_rpm


def torque_scale(drive: DriveDocument) -> float:
    return drive.rating.rated_torque_nm


def _current(drive: DriveDocument) -> float:
    return drive.rating.current_limit_a


def _power(drive: DriveDocument) -> float:
    return drive.rating.rated_power_w


def voltage_scale(drive: DriveDocument) -> float:
    """Return the whole link voltage (V)."""
    return _HALVES * drive.inverter.supply_voltage_v


def _of_hundred(_drive: DriveDocument) -> float:
    return _PERCENT


def _signal(
    name: str, words: str, unit: str, scale: Scale, follows: Literal["torque", ""] = "", remark: str = ""
) -> Quantity:
    """Make the row of a signal that the contract declares."""
    return Quantity(
        name, words, unit, (name,), lambda columns, _: columns[name], scale, follows, name, remark=remark
    )


def _rate(name: str) -> Compute:
    """Make what returns the change of a signal from one control period to the next, over the time (1/s)."""

    def rate(columns: Columns, _drive: DriveDocument) -> NDArray[np.float64]:
        change = columns[name].copy()
        change[1:] -= columns[name][:-1]
        change[:1] = 0.0
        time = columns["time_s"]
        return change / (float(time[1] - time[0]) if len(time) > 1 else 1.0)

    return rate


def _share(compute: Compute, of: Scale) -> Compute:
    """Make what returns a quantity in percent of a size of the drive."""
    return lambda columns, drive: compute(columns, drive) * (_PERCENT / of(drive))


def _speed_deviation(columns: Columns, _drive: DriveDocument) -> NDArray[np.float64]:
    return columns["speed_rpm"] - columns["speed_reference_rpm"]


def _torque_deviation(columns: Columns, _drive: DriveDocument) -> NDArray[np.float64]:
    return columns["torque_nm"] - columns["torque_reference_nm"]


def _amplitude(columns: Columns, _drive: DriveDocument) -> NDArray[np.float64]:
    # Rows are read where nothing needs arrays yet.
    import numpy as np

    direct, quadrature = columns["direct_current_a"], columns["quadrature_current_a"]
    # No hypot, whose last bits differ between processors.
    amplitude: NDArray[np.float64] = np.sqrt(direct * direct + quadrature * quadrature)
    return amplitude


def _shaft_power(columns: Columns, _drive: DriveDocument) -> NDArray[np.float64]:
    return columns["torque_nm"] * columns["speed_rpm"] * (pi / 30.0)


def _supply_current(columns: Columns, _drive: DriveDocument) -> NDArray[np.float64]:
    return columns["input_power_w"] / columns["link_voltage_v"]


def _torque_of(columns: Columns, _drive: DriveDocument) -> NDArray[np.float64]:
    return columns["torque_nm"]


def _base_speed(drive: DriveDocument) -> float:
    return drive.rating.base_speed_rpm


_SPEEDS: Final = ("speed_rpm", "speed_reference_rpm")
_TORQUES: Final = ("torque_nm", "torque_reference_nm")
_ALL: Final = (
    _signal("speed_rpm", "speed", "rpm", speed_scale),
    _signal("speed_reference_rpm", "speed reference", "rpm", speed_scale),
    Quantity(
        "speed_deviation_rpm",
        "speed deviation",
        "rpm",
        _SPEEDS,
        _speed_deviation,
        speed_scale,
        "speed",
        *_SPEEDS,
        remark="speed less its reference",
    ),
    Quantity(
        "speed_deviation_percent",
        "speed deviation",
        "%",
        _SPEEDS,
        _share(_speed_deviation, _base_speed),
        _of_hundred,
        "speed",
        remark="in percent of base speed",
    ),
    Quantity(
        "acceleration_rpm_per_s",
        "acceleration",
        "rpm/s",
        ("speed_rpm", "time_s"),
        _rate("speed_rpm"),
        lambda drive: speed_scale(drive) / mechanical_time(drive),
        remark="change of the speed from one control period to the next",
    ),
    _signal("measured_speed_rpm", "measured speed", "rpm", speed_scale),
    _signal("torque_nm", "torque", "N·m", torque_scale),
    _signal("torque_reference_nm", "torque reference", "N·m", torque_scale, follows="torque"),
    Quantity(
        "torque_deviation_nm",
        "torque deviation",
        "N·m",
        _TORQUES,
        _torque_deviation,
        torque_scale,
        "torque",
        *_TORQUES,
        remark="torque less its reference",
    ),
    Quantity(
        "torque_percent",
        "torque",
        "%",
        ("torque_nm",),
        _share(_torque_of, torque_scale),
        _of_hundred,
        remark="in percent of rated torque",
    ),
    _signal("load_torque_nm", "load torque", "N·m", torque_scale),
    _signal("direct_current_a", "d current", "A", _current),
    _signal("quadrature_current_a", "q current", "A", _current),
    Quantity(
        "current_a",
        "current amplitude",
        "A",
        ("direct_current_a", "quadrature_current_a"),
        _amplitude,
        _current,
        remark="of the d-q currents",
    ),
    Quantity(
        "current_percent",
        "current amplitude",
        "%",
        ("direct_current_a", "quadrature_current_a"),
        _share(_amplitude, _current),
        _of_hundred,
        remark="of the d-q currents, in percent of the current limit",
    ),
    _signal("peak_current_a", "phase current", "A", _current, remark="maximum of a control period"),
    _signal("current_sum_a", "current sum", "A", _current, remark="of the magnitudes of the phase currents"),
    _signal("current_reference_a", "current reference", "A", _current),
    _signal("advance_deg", "advance angle", "°", lambda _: 90.0),
    _signal("input_power_w", "input power", "W", _power, remark="from the link"),
    Quantity(
        "shaft_power_w",
        "shaft power",
        "W",
        ("torque_nm", "speed_rpm"),
        _shaft_power,
        _power,
    ),
    Quantity(
        "supply_current_a",
        "supply current",
        "A",
        ("input_power_w", "link_voltage_v"),
        _supply_current,
        lambda drive: _power(drive) / voltage_scale(drive),
        remark="from the link, the mean of a control period, negative into it",
    ),
    _signal("link_voltage_v", "link voltage", "V", voltage_scale),
    _signal("half_supply_v", "voltage of a half of the supply", "V", voltage_scale),
    _signal(
        "voltage_v", "phase voltage", "V", voltage_scale, remark="its peak, which the duty ratios request"
    ),
    _signal(
        "winding_temperature_c",
        "temperature of the windings",
        "°C",
        _of_hundred,
        remark="of a drive with a table [thermal]; a row does not apply to others",
    ),
)
QUANTITIES: Final[Mapping[str, Quantity]] = MappingProxyType({quantity.name: quantity for quantity in _ALL})
"""All of them by name, in the order in which they are listed."""


def quantities_of(signals: tuple[str, ...]) -> tuple[Quantity, ...]:
    """List the quantities of a contract that has some signals."""
    return tuple(each for each in _ALL if set(each.columns) <= set(signals))
