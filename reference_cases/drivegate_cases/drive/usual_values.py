"""Values of a drive that are far off its kind, as a wrong unit makes them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_models.units import RADIANS_PER_RPM

_MILLI = 1e-3
_PER_1000_RPM = 1.0 / (1000.0 * RADIANS_PER_RPM)


@dataclass(frozen=True)
class UsualRange:
    """What a key of a drive usually is in drives of its kind."""

    key: str
    """The key."""
    lowest: float
    highest: float
    """The range, so wide that only a wrong unit leaves it."""
    unit: str
    """The unit that is expected."""
    kind: str
    """What the range follows from, in words."""
    mistaken: tuple[tuple[str, float], ...] = ()
    """Units that the value may be in instead, each with its size in the expected one."""

    def holds(self, value: float) -> bool:
        """Tell whether a value is usual; 0 leaves something out, and is no wrong unit."""
        return value == 0.0 or self.lowest <= value <= self.highest

    def warning(self, value: float) -> str:
        """Tell a value that is not usual in one sentence."""
        names = (name for name, size in self.mistaken if self.holds(value * size))
        asked = next((f": is it in {name}?" for name in names), "")
        return (
            f"the drive's {self.key} is {value:g}, but usual {self.kind} is {self.lowest:.2g} to {self.highest:.2g}; "
            f"it is expected in {self.unit}{asked}"
        )


def unusual_values(drive: DriveDocument) -> tuple[str, ...]:
    """Tell each value that is far off its kind; what others are measured by comes alone."""
    if not drive.usual_values_are_known:
        return ()
    stages = (_of_any_drive(), _of_its_power(drive), _of_its_kind(drive))
    return next(filter(None, (_unusual(drive, ranges) for ranges in stages)), ())


def _unusual(drive: DriveDocument, ranges: Iterable[UsualRange]) -> tuple[str, ...]:
    values = ((usual, float(drive.value(usual.key))) for usual in ranges)
    return tuple(usual.warning(value) for usual, value in values if not usual.holds(value))


def _of_any_drive() -> tuple[UsualRange, ...]:
    """Give the ranges of what a kind of drive begins with."""
    return (
        UsualRange(
            "supply_voltage_v",
            1.0,
            5e3,
            "volts",
            "for drives",
            (("millivolts", _MILLI), ("kilovolts", 1e3)),
        ),
        UsualRange(
            "base_speed_rpm",
            5.0,
            2e5,
            "turns a minute",
            "for drives",
            (("thousands of turns a minute", 1e3),),
        ),
    )


def _of_its_power(drive: DriveDocument) -> tuple[UsualRange, ...]:
    """Give the range of the current, as a multiple of what the power takes."""
    current = drive.rating.rated_power_w / (drive.machine.phases * drive.inverter.supply_voltage_v)
    return (
        UsualRange(
            "current_limit_a",
            0.1 * current,
            100.0 * current,
            "ampere",
            f"for {drive.rating.rated_power_w:g} W from {drive.inverter.supply_voltage_v:g} V "
            f"in {drive.machine.phases} phases",
            (("milliampere", _MILLI), ("kiloampere", 1e3)),
        ),
    )


def _of_its_kind(drive: DriveDocument) -> tuple[UsualRange, ...]:
    """Give the ranges of what follows from the kind of drive, each as a share of what its ratings make of it."""
    speed = drive.rating.base_speed_rpm * RADIANS_PER_RPM
    impedance = drive.inverter.supply_voltage_v / drive.rating.current_limit_a
    inductance = impedance / (drive.machine.pole_pairs * speed)
    emf = drive.inverter.supply_voltage_v / speed
    torque = drive.rating.rated_power_w / speed
    electrical = f"for {drive.inverter.supply_voltage_v:g} V and {drive.rating.current_limit_a:g} A"
    rated = f"for {drive.rating.rated_power_w:g} W at {drive.rating.base_speed_rpm:g} rpm"
    return (
        UsualRange(
            "resistance_ohm",
            1e-3 * impedance,
            3.0 * impedance,
            "ohm",
            electrical,
            (("milliohm", _MILLI), ("microohm", 1e-6)),
        ),
        UsualRange(
            "inductance_h",
            0.01 * inductance,
            10.0 * inductance,
            "henry",
            f"{electrical} at {drive.rating.base_speed_rpm:g} rpm and {drive.machine.pole_pairs} pole pairs",
            (("millihenry", _MILLI), ("microhenry", 1e-6)),
        ),
        UsualRange(
            "emf_constant_v_s_per_rad",
            0.02 * emf,
            5.0 * emf,
            "volt seconds per radian",
            f"for {drive.inverter.supply_voltage_v:g} V at {drive.rating.base_speed_rpm:g} rpm",
            (("volts per 1000 turns a minute", _PER_1000_RPM), ("millivolt seconds per radian", _MILLI)),
        ),
        UsualRange(
            "inertia_kg_m2",
            1e-3 * torque / speed,
            30.0 * torque / speed,
            "kilogram square metres",
            rated,
            (
                ("gram square metres", _MILLI),
                ("kilogram square centimetres", 1e-4),
                ("gram square centimetres", 1e-7),
            ),
        ),
        UsualRange(
            "hysteresis_band_a",
            1e-4 * drive.rating.current_limit_a,
            0.5 * drive.rating.current_limit_a,
            "ampere",
            f"for {drive.rating.current_limit_a:g} A",
            (("milliampere", _MILLI),),
        ),
        UsualRange(
            "friction_n_m",
            0.0,
            0.5 * torque,
            "newton metres",
            rated,
            (("millinewton metres", _MILLI),),
        ),
        UsualRange(
            "viscous_friction_n_m_s_per_rad",
            0.0,
            0.5 * torque / speed,
            "newton metre seconds per radian",
            rated,
            (("millinewton metre seconds per radian", _MILLI),),
        ),
        UsualRange(
            "core_loss_conductance_s",
            0.0,
            0.5 / impedance,
            "siemens",
            electrical,
            (("millisiemens", _MILLI),),
        ),
    )
