"""Values of a drive that are far off its kind, as a wrong unit makes them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final, Protocol, Self

from drivegate_cases.drive.rating import Rating
from drivegate_models.units import RADIANS_PER_RPM

_MILLI = 1e-3
_PER_1000_RPM = 1.0 / (1000.0 * RADIANS_PER_RPM)
_MOST_ASKED: Final = 3
"""Units that a warning asks about at most."""


class DriveValues(Protocol):
    """The values of a drive of any kind, and what follows from them; `document.DriveDocument` describes each.

    Modules that the document imports take this in its place.
    """

    def __hash__(self) -> int: ...

    @property
    def name(self) -> str: ...

    @property
    def rating(self) -> Rating: ...

    @property
    def machine(self) -> Any: ...

    @property
    def inverter(self) -> Any: ...

    @property
    def advance(self) -> Any: ...

    @property
    def requirements(self) -> Any: ...

    @property
    def has_split_supply(self) -> bool: ...

    @property
    def position(self) -> str: ...

    @property
    def provenance(self) -> dict[str, dict[str, str]]: ...

    def value(self, key: str) -> Any: ...

    def replaced(self, **changes: Any) -> Self: ...

    def usual_ranges(self) -> tuple[tuple[Any, ...], ...]: ...

    def torque_of_current(self, current: float) -> float: ...

    def greatest_torque(self, current: float, speed: float) -> float: ...

    def plant(self) -> Any: ...


_VOLTS: Final = "volts", (("millivolts", _MILLI), ("kilovolts", 1e3))
_HENRY: Final = "henry", (("millihenry", _MILLI), ("microhenry", 1e-6))
_UNITS: Final[Mapping[str, tuple[str, tuple[tuple[str, float], ...]]]] = {
    "supply_voltage_v": _VOLTS,
    "link_voltage_v": _VOLTS,
    "base_speed_rpm": ("turns a minute", (("thousands of turns a minute", 1e3),)),
    "current_limit_a": ("ampere", (("milliampere", _MILLI), ("kiloampere", 1e3))),
    "hysteresis_band_a": ("ampere", (("milliampere", _MILLI),)),
    "resistance_ohm": ("ohm", (("milliohm", _MILLI), ("microohm", 1e-6))),
    "inductance_h": _HENRY,
    "direct_inductance_h": _HENRY,
    "quadrature_inductance_h": _HENRY,
    "emf_constant_v_s_per_rad": (
        "volt seconds per radian",
        (("volts per 1000 turns a minute", _PER_1000_RPM), ("millivolt seconds per radian", _MILLI)),
    ),
    "magnet_flux_v_s": ("volt seconds", ()),
    "inertia_kg_m2": (
        "kilogram square metres",
        (
            ("gram square metres", _MILLI),
            ("kilogram square centimetres", 1e-4),
            ("gram square centimetres", 1e-7),
        ),
    ),
    "friction_n_m": ("newton metres", (("millinewton metres", _MILLI),)),
    "viscous_friction_n_m_s_per_rad": (
        "newton metre seconds per radian",
        (("millinewton metre seconds per radian", _MILLI),),
    ),
    "core_loss_conductance_s": ("siemens", (("millisiemens", _MILLI),)),
}
"""The unit of each key, and those that its value may be in instead, each with its size in that one."""


@dataclass(frozen=True)
class UsualRange:
    """What a key of a drive usually is in drives of its kind."""

    key: str
    lowest: float
    highest: float
    """The range, so wide that only a wrong unit leaves it."""
    kind: str
    """What the range follows from, in words."""
    power_slips: bool = False
    """Whether a rated power in kilowatts has the same effect as a value in thousandths."""
    other_quantities: tuple[tuple[str, Callable[[float], float]], ...] = ()
    """Units of other quantities that the value may be, each with the conversion to this one."""

    def holds(self, value: float) -> bool:
        """Return True if a value is usual; 0 leaves something out, and is no wrong unit."""
        return value == 0.0 or self.lowest <= value <= self.highest

    def warning(self, value: float) -> str:
        unit, mistaken = _UNITS[self.key]
        names = [name for name, size in mistaken if self.holds(value * size)]
        names += [name for name, converted in self.other_quantities if self.holds(converted(value))]
        questions = [f"is it in {_either(names[:_MOST_ASKED])}"] if names else []
        if self.power_slips and self.holds(value * _MILLI):
            questions.append("is rated_power_w in kilowatts")
        question = f": {', or '.join(questions)}?" if questions else ""
        return (
            f"the drive's {self.key} is {value:g}, but usual {self.kind} is {_short(self.lowest)} to "
            f"{_short(self.highest)}; it is expected in {unit}{question}"
        )


def _either(names: list[str]) -> str:
    return " or ".join(filter(None, (", ".join(names[:-1]), names[-1])))


def _short(value: float) -> str:
    """Write a bound with two digits, and with an exponent only where it is very small or large."""
    return f"{float(f'{value:.2g}'):g}"


def unusual_keys(drive: DriveValues) -> dict[str, str]:
    """Describe each value far outside its usual range, by key; one that others are compared with comes alone."""
    for ranges in drive.usual_ranges():
        values = [(usual, float(drive.value(usual.key))) for usual in ranges]
        if unusual := {usual.key: usual.warning(value) for usual, value in values if not usual.holds(value)}:
            return unusual
    return {}


def unusual_values(drive: DriveValues) -> tuple[str, ...]:
    return tuple(unusual_keys(drive).values())


def ranges_of_supply_and_speed(supply_key: str) -> tuple[UsualRange, ...]:
    """Return the ranges of what every other value is compared with."""
    return (
        UsualRange(supply_key, 1.0, 5e3, "for drives"),
        UsualRange("base_speed_rpm", 5.0, 2e5, "for drives"),
    )


def range_of_current(drive: DriveValues, volts: float, phases: str) -> tuple[UsualRange, ...]:
    """Return the range of the current limit, as a multiple of the current that the rated power needs.

    ``volts`` is the supply as the drive's file states it, and ``phases`` ends the sentence about it.
    """
    current = drive.rating.rated_power_w / (drive.machine.phases * drive.inverter.supply_voltage_v)
    kind = f"for {drive.rating.rated_power_w:g} W from {volts:g} V{phases}"
    return (UsualRange("current_limit_a", 0.1 * current, 100.0 * current, kind, power_slips=True),)


@dataclass(frozen=True)
class UsualScale:
    """The quantities that usual values are shares of."""

    impedance: float
    """Voltage of a phase over the current limit (ohm)."""
    speed: float
    """Base speed (rad/s)."""
    torque: float
    """Rated torque at base speed (N·m)."""
    electrical: str
    """Supply and current limit, as a sentence names them."""
    rated: str
    """Rated power and base speed, as a sentence names them."""
    geared: str
    """Base speed and pole pairs, as a sentence names them."""

    def resistance(self) -> UsualRange:
        return UsualRange("resistance_ohm", 1e-3 * self.impedance, 3.0 * self.impedance, self.electrical)

    def inductance(self, key: str, pole_pairs: int) -> UsualRange:
        inductance = self.impedance / (pole_pairs * self.speed)
        return UsualRange(key, 0.01 * inductance, 10.0 * inductance, f"{self.electrical} {self.geared}")

    def shaft_and_core(self) -> tuple[UsualRange, ...]:
        torque, rated = self.torque, self.rated
        return (
            UsualRange("inertia_kg_m2", 1e-3 * torque / self.speed, 30.0 * torque / self.speed, rated),
            UsualRange("friction_n_m", 0.0, 0.5 * torque, rated),
            UsualRange("viscous_friction_n_m_s_per_rad", 0.0, 0.5 * torque / self.speed, rated),
            UsualRange("core_loss_conductance_s", 0.0, 0.5 / self.impedance, self.electrical),
        )


def usual_scale(drive: DriveValues, phase_voltage: float, volts: float) -> UsualScale:
    """Return the scale of a drive, from the voltage of one phase and the supply as its file states it (V)."""
    rating = drive.rating
    speed = rating.base_speed_rpm * RADIANS_PER_RPM
    return UsualScale(
        phase_voltage / rating.current_limit_a,
        speed,
        rating.rated_power_w / speed,
        f"for {volts:g} V and {rating.current_limit_a:g} A",
        f"for {rating.rated_power_w:g} W at {rating.base_speed_rpm:g} rpm",
        f"at {rating.base_speed_rpm:g} rpm and {drive.machine.pole_pairs} pole pairs",
    )


def ranges_of_current_fed(drive: DriveValues) -> tuple[tuple[UsualRange, ...], ...]:
    """Return the ranges of a drive whose controllers request currents, in the order in which they are compared."""
    volts = drive.inverter.supply_voltage_v
    scale = usual_scale(drive, volts, volts)
    emf, limit = volts / scale.speed, drive.rating.current_limit_a
    return (
        ranges_of_supply_and_speed("supply_voltage_v"),
        range_of_current(drive, volts, f" in {drive.machine.phases} phases"),
        (
            scale.resistance(),
            scale.inductance("inductance_h", drive.machine.pole_pairs),
            UsualRange(
                "emf_constant_v_s_per_rad",
                0.02 * emf,
                5.0 * emf,
                f"for {volts:g} V at {drive.rating.base_speed_rpm:g} rpm",
            ),
            UsualRange("hysteresis_band_a", 1e-4 * limit, 0.5 * limit, f"for {limit:g} A"),
            *scale.shaft_and_core(),
        ),
    )
