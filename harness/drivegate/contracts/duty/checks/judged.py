"""From a run's record to that of a run with duty ratios, and the worst of several margins."""

from __future__ import annotations

from collections.abc import Iterable
from math import isfinite
from typing import TYPE_CHECKING, Any, Final

from drivegate.checks.margin import Margin
from drivegate.checks.record import Record
from drivegate.contracts.duty.checks.optimum import greatest_at
from drivegate.contracts.duty.record import DutyRecord, DutyWindow
from drivegate_models.units import RADIANS_PER_RPM

if TYPE_CHECKING:
    from drivegate_models.pm_ac.plant.drive import PmAcDrive

UNWEAKENED_FAMILIES: Final = (
    "torque step",
    "speed step",
    "reversal",
    "load step",
    "hoist",
    "low speed",
    "start",
    "restart",
    "supply step",
    "torque supply step",
)
"""Families of scenarios with a steady state below weakening."""
STEADY_FAMILIES: Final = ("torque step", "weakening", *UNWEAKENED_FAMILIES[1:])
"""Families of scenarios with any steady state."""


def duty_record(record: Record) -> DutyRecord:
    """Take a record for what it is here."""
    assert isinstance(record, DutyRecord), "a check of duty ratios judges runs with duty ratios"
    return record


def plant_of(record: DutyRecord) -> PmAcDrive:
    """Return the plant that the run was made on."""
    drive: Any = record.drive
    plant: PmAcDrive = drive
    return plant


def worst(margins: Iterable[Margin | None]) -> Margin | None:
    """Return the least of the margins of one run, of those that are there; None without any."""
    known = (margin for margin in margins if margin is not None)
    return min(known, key=lambda margin: margin.value, default=None)


def greatest_required(record: DutyRecord, speed: float, link: float) -> float:
    """Return the greatest driving torque with the voltage that a controller must use (N·m); NaN where there is none."""
    voltage, weakens = record.limits.weakening_voltage * link, record.document.weakens
    return greatest_at(plant_of(record), abs(speed), voltage, weakens=weakens).torque


def is_within_reach(record: DutyRecord, speed: float, link: float, torque: float) -> bool:
    """Return True if a controller must reach a torque at a speed and a link voltage."""
    greatest = greatest_required(record, speed, link)
    return isfinite(greatest) and abs(torque) <= record.limits.weakening * greatest


def at(window: DutyWindow) -> str:
    """State where in a run a window is."""
    return f"at {window.speed / RADIANS_PER_RPM:.5g} rpm, {window.start_s:.4g} to {window.end_s:.4g} s"
