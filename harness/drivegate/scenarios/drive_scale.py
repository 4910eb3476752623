"""What scenarios take from their drive: speeds, loads, disturbances and times, each with the reason for its size."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final, TypeAlias

from drivegate_cases.documents.document import parse_document
from drivegate_cases.documents.wording import significant
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import SETTLING, mechanical_time, nearest_step, time_unit
from drivegate_models.controllers.current.regulator_rates import (
    BANDWIDTH,
    FASTEST_OF_FREQUENCY,
    INTEGRAL_RATE,
    TUNED_FREQUENCY,
    TUNED_TIME,
)
from drivegate_models.errors import InputError
from drivegate_models.units import RADIANS_PER_RPM

_KEPT: Final = 100
# Speed that a load may cost while it comes on, over base speed (1).
_RAMP_COST: Final = 0.05
# What the rates of the reference controller's regulator give (rad²).
_RAMP_ANGLE: Final = TUNED_FREQUENCY * TUNED_FREQUENCY / (_RAMP_COST * BANDWIDTH * INTEGRAL_RATE)
# Angle in a mechanical time constant (rad) below which that regulator is faster.
_LIGHT_ANGLE: Final = TUNED_TIME * TUNED_FREQUENCY
SpeedRange: TypeAlias = tuple[float, float]
"""Lowest and highest speed (rpm)."""


@dataclass(frozen=True)
class DriveScale:
    """What follows from a drive for the scenarios that candidates are checked on.

    Sizes are shares of the rating, in steps of 1, 2, 5 times a power of ten or of two digits, so that people can read
    them. Times are multiples of a unit that the drive's time constants give (`drivegate_cases.drive.limits.time_unit`).
    The control period, the encoder, the clock and the converters are the sensors' and the contract's, not the drive's.
    """

    base_speed_rpm: float
    """Speed below which there is no advance (rpm)."""
    lowest_loaded_rpm: float
    """Lowest speed of a loaded run (rpm): 5 % into the range of constant power; nearer to base speed, rated
    power is out of reach without advance."""
    highest_loaded_rpm: float
    """Speed up to which constant power is required (rpm)."""
    overspeed_rpm: float
    """Speed up to which constant power is advised (rpm)."""
    speed_grain_rpm: float
    """What chosen speeds are rounded to (rpm): about 1 % of base speed, the default of k1."""
    speed_step_rpm: float
    """Step of drawn speeds (rpm): about 2 % of base speed, so that neighbours differ by more than k1."""
    rated_torque_nm: float
    """Torque of rated power at base speed (N m)."""
    torque_step_nm: float
    """Step of friction that is added (N m): 0.35 % of rated torque; five of them are what is claimed."""
    standstill_torque_nm: float
    """Greatest torque of a joint run that comes to a standstill (N m): 42 % of rated torque, which needs no
    advance."""
    offset_step_a: float
    """Step of a current sensor's offset (A): about 0.08 % of the current limit; ten of them are drawn."""
    supply_step_v: float
    """Finest rounding of the supply (V): about 0.2 % of its voltage."""
    current_sum_a: float
    """Current sum of scripts (A): about a third of what all phases carry at the current limit."""
    mass_unit_kg: float
    """Mass of a vehicle per unit (kg), in proportion to rated power; a light vehicle has three or four."""
    gear_unit: float
    """Gear ratio per unit (1), in proportion to the highest speed, so that vehicles are equally fast."""
    drag_area_m2: float
    """Drag area of a vehicle (m²), in proportion to rated power."""
    time_unit_s: float
    """The unit of time (s), in which a search decides at least ten times."""
    load_ramp_s: float
    """Time in which a load comes on, so that a run starts in a true steady state, unloaded at speed (s): a
    fifth of a unit, and where torque is large for the inertia and for what an electrical period lets a speed
    regulator do, as long as it takes to lose no more than 5 % of base speed."""
    load_ramp_cost_rpm: float
    """Speed that the reference controller loses while rated torque comes on in that time (rpm)."""
    settling_s: float
    """Time within which a search has to converge at a steady speed reference (s)."""
    shortest_window_s: float
    """Shortest time over which convergence is judged (s): 3 units, many electrical periods."""
    dropout_step_s: float
    """Step of the time for which a signal is lost (s): 1 ms, or 1 % of the mechanical time constant where
    that is less, but no less than the longest control period."""

    @property
    def friction_claimed_nm(self) -> float:
        """Greatest friction that is added to the drive's own (N m)."""
        return tidy(5 * self.torque_step_nm)

    @property
    def dwell_s(self) -> float:
        """Length of a steady stretch: the time to converge, and four units to be judged (s)."""
        return self.settling_s + 4.0 * self.time_unit_s

    @property
    def change_s(self) -> float:
        """Time of a change after a search that has converged (s)."""
        return self.dwell_s

    @property
    def change_step_s(self) -> float:
        """Step of the times of changes (s)."""
        return 0.05 * self.change_s

    @property
    def settled_s(self) -> float:
        """Time of a joint change after a search that has converged (s)."""
        return self.settling_s + self.time_unit_s

    @property
    def tenth_s(self) -> float:
        """Step of the times that something lasts (s)."""
        return 0.1 * self.time_unit_s

    @property
    def repeated_every_s(self) -> float:
        """Time from one repetition of a disturbance to the next (s), in which no search comes to rest."""
        return 0.4 * self.time_unit_s

    @property
    def step_acceleration_s(self) -> float:
        """Time in which a step up of the speed reference must be possible, a third of the time to converge (s)."""
        return self.settling_s / 3.0

    @property
    def long_s(self) -> float:
        """Length of a long run, beside which the time of every search is short (s)."""
        return 25.0 * self.settling_s

    def speed(self, share: float) -> float:
        """Return a speed (rpm) by its share of the range from base speed to the highest."""
        wished = self.base_speed_rpm + share * (self.highest_loaded_rpm - self.base_speed_rpm)
        return min(max(self._on_grain(wished), self.lowest_loaded_rpm), self.highest_loaded_rpm)

    def speed_beyond(self, share: float) -> float:
        """Return a speed (rpm) by its share of the range from the highest to overspeed."""
        wished = self.highest_loaded_rpm + share * (self.overspeed_rpm - self.highest_loaded_rpm)
        return min(max(self._on_grain(wished), self.highest_loaded_rpm), self.overspeed_rpm)

    def around_base(self, grains: int) -> float:
        """Return a speed (rpm) so many grains above base speed, or below."""
        return tidy(self.base_speed_rpm + grains * self.speed_grain_rpm)

    def units(self, count: float) -> float:
        """Return a time of so many units (s)."""
        return tidy(count * self.time_unit_s)

    def _on_grain(self, speed_rpm: float) -> float:
        return tidy(round(speed_rpm / self.speed_grain_rpm) * self.speed_grain_rpm)


@lru_cache(maxsize=_KEPT)
def scale_of(drive: DriveDocument) -> DriveScale:
    rating = drive.rating
    base, highest, power = rating.base_speed_rpm, rating.highest_speed_rpm, rating.rated_power_w
    grain = nearest_step(0.01 * base)
    lowest = base + 0.05 * (highest - base)
    whole = tidy(round(lowest / grain) * grain)
    torque = rating.rated_torque_nm
    unit = time_unit(drive)
    ramp = max(0.2 * unit, nearest_step(_load_ramp(drive)))
    faster = _times_faster(drive)
    return DriveScale(
        base_speed_rpm=base,
        lowest_loaded_rpm=whole if base < whole < highest else tidy(lowest),
        highest_loaded_rpm=highest,
        overspeed_rpm=rating.overspeed_rpm,
        speed_grain_rpm=grain,
        speed_step_rpm=nearest_step(0.02 * base),
        rated_torque_nm=torque,
        torque_step_nm=nearest_step(0.0035 * torque),
        standstill_torque_nm=significant(0.42 * torque, 2),
        offset_step_a=nearest_step(0.00077 * rating.current_limit_a),
        supply_step_v=nearest_step(0.0021 * drive.inverter.supply_voltage_v),
        current_sum_a=significant(0.31 * drive.machine.phases * rating.current_limit_a, 2),
        mass_unit_kg=significant(power / 30.0, 2),
        gear_unit=significant(highest / 1500.0, 2),
        drag_area_m2=significant(power / 2500.0, 2),
        time_unit_s=unit,
        load_ramp_s=ramp,
        load_ramp_cost_rpm=_RAMP_COST * base * _load_ramp(drive) / (ramp * faster * faster),
        settling_s=SETTLING.on(drive, "settling_s"),
        shortest_window_s=3.0 * unit,
        dropout_step_s=min(max(nearest_step(0.011 * mechanical_time(drive)), 0.0005), 0.001),
    )


def _load_ramp(drive: DriveDocument) -> float:
    """Return the time of a ramp to rated torque that costs a twentieth of base speed (s).

    Against a ramp, a proportional-integral regulator is off by the ramp's slope over inertia and both its rates, and
    these are shares of the electrical frequency: beyond, torque ripple would be taken for speed.
    """
    frequency = _base_frequency(drive)
    return _RAMP_ANGLE / (frequency * frequency * mechanical_time(drive))


def _times_faster(drive: DriveDocument) -> float:
    """Return both rates of the reference controller's regulator over those of a heavy shaft (1)."""
    angle = _base_frequency(drive) * mechanical_time(drive)
    return min(max(_LIGHT_ANGLE / angle, 1.0), FASTEST_OF_FREQUENCY)


def _base_frequency(drive: DriveDocument) -> float:
    """Return the electrical frequency at base speed (rad/s)."""
    return drive.machine.pole_pairs * drive.rating.base_speed_rpm * RADIANS_PER_RPM


def scale_of_mapping(drive: Mapping[str, Any]) -> DriveScale:
    return _scale_of_text(json.dumps(drive, sort_keys=True))


@lru_cache(maxsize=_KEPT)
def _scale_of_text(text: str) -> DriveScale:
    return scale_of(parse_document(json.loads(text), DriveDocument, "the scenario's drive"))


def rated_torque_at(drive: DriveDocument, speed_rpm: float) -> float:
    """Return the torque of rated power at a speed, constant below base speed (N·m)."""
    speed = max(abs(speed_rpm), drive.rating.base_speed_rpm) * RADIANS_PER_RPM
    return drive.rating.rated_power_w / speed


def tidy(value: float) -> float:
    """Take off what binary fractions add to sums of decimal ones."""
    return round(value, 9)


def whole_tenths(time_s: float) -> float:
    """Return the next whole tenth of a second, which is a whole number of all usual control periods."""
    return math.ceil(round(time_s * 10.0, 6)) / 10.0


def loaded_range(drive: DriveDocument, declared_rpm: SpeedRange | None) -> SpeedRange:
    """Return the speeds of loaded runs."""
    scale = scale_of(drive)
    lowest, highest = scale.lowest_loaded_rpm, scale.highest_loaded_rpm
    if declared_rpm is None:
        return lowest, highest
    if declared_rpm[1] < lowest or declared_rpm[0] > highest:
        raise InputError(
            f"the candidate declares a speed_range_rpm of {declared_rpm[0]:g} to {declared_rpm[1]:g} rpm, but is "
            f"checked under load from {lowest:g} to {highest:g} rpm; declare a range that has some of these speeds"
        )
    return max(lowest, declared_rpm[0]), min(highest, declared_rpm[1])
