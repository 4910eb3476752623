"""The drives that the paper's introduction names, at the same operating points: five phases, stars and PM AC.

No controller runs on all of them, so each is taken at the best that it can do: the 5-phase drive and the star at the
angle of least Σ|i|, with the ideal current regulator; the PM AC drives at the least current that gives the torque
within the voltage that a two-level bridge gives without distortion. None has core loss, forward drops or a ripple
of switching.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from math import inf, isfinite, nan, pi, radians, sin
from typing import Final

from drivegate.contracts.duty.document import duty_document
from drivegate.drives.constant_power import last_met
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_lab.paper.drives import (
    FASTEST_RPM,
    HIGHEST_PUBLISHED_RPM,
    compared_drives,
    power_torque,
    reference_drive,
    ripple_percent,
    star,
)
from drivegate_models.machine.rotor_frame import SUM_OVER_PEAK
from drivegate_models.pm_ac.fundamental import SteadyState
from drivegate_models.pm_ac.oracle import CURRENT, greatest_torque, least_at, undistorted_limits
from drivegate_models.steady.oracle import greatest_torque_at_limit, least_current_sum, point_at_torque
from drivegate_models.units import RADIANS_PER_RPM

_SLOWEST_RPM: Final = 250.0
_STEP_RPM: Final = 125.0
_PLACES: Final = round((FASTEST_RPM - _SLOWEST_RPM) / _STEP_RPM) + 1
_HALVINGS: Final = 12


@dataclass(frozen=True)
class OperatingPoint:
    """A power at a speed, at the best that a drive can do; NaN throughout where that is out of reach."""

    ripple_percent: float
    """Torque ripple, peak to peak over mean (%)."""
    current_sum_a: float
    """Mean of the sum of current magnitudes (A)."""
    copper_loss_w: float
    input_w: float
    """Copper loss and net input power (W)."""


OUT_OF_REACH: Final = OperatingPoint(nan, nan, nan, nan)
"""Where no current within the limits gives the torque."""


@dataclass(frozen=True)
class KindOfDrive:
    """A drive of the comparison."""

    name: str
    """What it is called in figures."""
    document: DriveDocument
    """The drive, without band and core loss."""
    at: Callable[[float, float], OperatingPoint]
    """From a speed (rpm) and a power at the shaft (W) to the operating point."""
    greatest_power: Callable[[float], float]
    """From a speed (rpm) to the greatest power at the current limit (W); NaN or less than nothing where there
    is none."""

    @property
    def current_sum_base_a(self) -> float:
        """Current limit of all phases, the base of Σ|i| per unit (A)."""
        return self.document.machine.phases * self.document.rating.current_limit_a

    def power_range(self, power_w: float) -> tuple[float, float] | None:
        """Find the first range of speeds with a power, `FASTEST_RPM` at most (rpm); None where there is none."""
        speeds = [_SLOWEST_RPM + _STEP_RPM * place for place in range(_PLACES)]
        enough = [self.greatest_power(speed) >= power_w for speed in speeds]
        if not any(enough):
            return None
        first = enough.index(True)
        last = next((place for place in range(first, _PLACES) if not enough[place]), _PLACES) - 1

        def has_power(speed_rpm: float) -> bool:
            return self.greatest_power(speed_rpm) >= power_w

        slowest, fastest = speeds[first], speeds[last]
        if first > 0:
            slowest = last_met(has_power, slowest, speeds[first - 1], _HALVINGS)
        if last < _PLACES - 1:
            fastest = last_met(has_power, fastest, speeds[last + 1], _HALVINGS)
        return slowest, fastest


@cache
def kinds_of_drives() -> tuple[KindOfDrive, ...]:
    """List the paper's drive, the star of its copper, two PM AC drives of all of it, and one of three of the phases."""
    five, plain, *_ = compared_drives()
    three = load_drive("pm-ac-surface").replaced(core_loss_conductance_s=0.0)
    return (
        _of_angles(five.name, five.document),
        _of_angles(plain.name, plain.document),
        _of_duty_ratios("PM AC, the trapezoid's fundamental", _of_all_copper(three, _fundamental())),
        _of_duty_ratios("PM AC, a sine as high", _of_all_copper(three, 1.0)),
        _of_duty_ratios("pm-ac-surface, three phases of five", three),
    )


def _of_all_copper(three: DriveDocument, emf_factor: float) -> DriveDocument:
    """Wind the copper of five phases into three, as the star has it."""
    copper = star()
    return three.replaced(
        resistance_ohm=copper.machine.resistance_ohm,
        direct_inductance_h=copper.machine.inductance_h,
        quadrature_inductance_h=copper.machine.inductance_h,
        magnet_flux_v_s=emf_factor * float(three.value("magnet_flux_v_s")),
        current_limit_a=copper.rating.current_limit_a,
    )


def _fundamental() -> float:
    """Return the fundamental of the EMF of the paper's drive over its height: 4 sin r / (pi r), with ramps of r."""
    flat = reference_drive().machine.emf_flat_deg
    assert flat is not None, "the paper's drive has a trapezoidal EMF"
    ramp = radians(0.5 * (180.0 - flat))
    return 4.0 * sin(ramp) / (pi * ramp)


def _of_angles(name: str, document: DriveDocument) -> KindOfDrive:
    plant = document.plant()

    def at(speed_rpm: float, power_w: float) -> OperatingPoint:
        speed, torque = speed_rpm * RADIANS_PER_RPM, power_torque(speed_rpm, power_w)
        least = least_current_sum(plant, speed, torque)
        if not isfinite(least.advance):
            return OUT_OF_REACH
        point = point_at_torque(plant, speed, least.advance, torque)
        return OperatingPoint(ripple_percent(point), point.current_sum, point.copper_loss, point.input_power)

    @cache
    def greatest_power(speed_rpm: float) -> float:
        speed = speed_rpm * RADIANS_PER_RPM
        return speed * greatest_torque_at_limit(plant, speed).torque

    return KindOfDrive(name, document, at, greatest_power)


def _of_duty_ratios(name: str, document: DriveDocument) -> KindOfDrive:
    plant = duty_document(document).plant()
    limits = undistorted_limits(plant)

    def at(speed_rpm: float, power_w: float) -> OperatingPoint:
        speed, torque = speed_rpm * RADIANS_PER_RPM, power_torque(speed_rpm, power_w)
        state: SteadyState = least_at(plant, limits, speed, torque, CURRENT)
        if not isfinite(state.current):
            return OUT_OF_REACH
        # Sinusoidal currents and EMF give an even torque.
        return OperatingPoint(
            0.0, SUM_OVER_PEAK * state.current, state.copper_loss, torque * speed + state.loss
        )

    @cache
    def greatest_power(speed_rpm: float) -> float:
        speed = speed_rpm * RADIANS_PER_RPM
        torque = greatest_torque(plant, limits, speed).torque
        return speed * torque if isfinite(torque) else -inf

    return KindOfDrive(name, document, at, greatest_power)


@cache
def common_power_w() -> float:
    """Return the power at which the drives are compared: rated power of the one of three phases, the smallest (W)."""
    return load_drive("pm-ac-surface").rating.rated_power_w


def in_words(drive: KindOfDrive, speed_rpm: float, power_w: float) -> str:
    """Write an operating point, absolute and per unit."""
    point = drive.at(speed_rpm, power_w)
    if not isfinite(point.current_sum_a):
        return "out of reach"
    return (
        f"Σ|i| {point.current_sum_a:.1f} A ({point.current_sum_a / drive.current_sum_base_a:.3f} pu), ripple "
        f"{point.ripple_percent:.0f} %, copper {point.copper_loss_w:.1f} W ({point.copper_loss_w / power_w:.4f} pu), "
        f"input {point.input_w:.1f} W"
    )


def range_in_words(drive: KindOfDrive, power_w: float) -> str:
    """Write the range of speeds with a power, as far as was looked."""
    found = drive.power_range(power_w)
    if found is None:
        return f"nowhere up to {FASTEST_RPM:.0f} rpm"
    slowest, fastest = found
    start = f"from {slowest:.0f}" if slowest > _SLOWEST_RPM else f"from {slowest:.0f} or less"
    return f"{start} to {'at least ' if fastest >= FASTEST_RPM else ''}{fastest:.0f} rpm"


def numbers_of_kinds() -> list[tuple[str, str]]:
    """Return every drive's losses and ranges, as the numbers of a finding."""
    power, rated, speed = common_power_w(), reference_drive().rating.rated_power_w, HIGHEST_PUBLISHED_RPM
    rows: list[tuple[str, str]] = []
    for drive in kinds_of_drives():
        rows += [
            (f"{drive.name}, {power:g} W at {speed:.0f} rpm", in_words(drive, speed, power)),
            (f"{drive.name}, {rated / 1000.0:g} kW at {speed:.0f} rpm", in_words(drive, speed, rated)),
            (f"{drive.name}, {rated / 1000.0:g} kW", range_in_words(drive, rated)),
        ]
    return rows
