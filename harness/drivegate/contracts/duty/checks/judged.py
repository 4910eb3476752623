"""What checks share: the record of a run with duty ratios, the worst of several margins, and the drive's optimum."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from math import isfinite, nan
from typing import Final, Literal, TypeAlias, TypeVar

from drivegate.candidates.declaration import Declaration
from drivegate.checks.check import Record
from drivegate.checks.margin import Margin
from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.record import DutyRecord, DutyWindow
from drivegate.contracts.duty.scenarios.reaching import BRAKING_SHARE
from drivegate.scenarios.rotation import sense_of
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.pm_ac.greatest_torque import braking_within, greatest_within
from drivegate_models.pm_ac.fundamental import SteadyState
from drivegate_models.pm_ac.link_oracle import least_power, most_power
from drivegate_models.pm_ac.oracle import CURRENT, LOSS, Limits, least_at, undistorted_limits
from drivegate_models.pm_ac.plant.dc_link import is_ideal
from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.units import RADIANS_PER_RPM

Purpose: TypeAlias = Literal["current", "loss"]
"""What is to be least."""

PartT = TypeVar("PartT")
"""What a check judges apart: a stretch, a step, or runs that it compares."""

SHOWN_BEFORE: Final = 10
"""Control periods before a step that figures show."""
_KEPT: Final = 20_000
_UNLIMITED_V: Final = 1e9
SUPPLIED_SHARE: Final = 0.9
"""Share of what source and chopper supply, or take back, within which they limit no current (1)."""
SENSORLESS_ANGLE_DEG: Final = 5.0
"""Greatest mean error of the angle without a position sensor (electrical degrees)."""
TURNED_SHARE: Final = 0.0872
"""Share of the q current that this angle turns into the d axis: its sine (1)."""
LOST_SHARE: Final = 0.0038
"""Current that it costs: the inverse of its cosine, less 1 (1)."""
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
    "joint change",
)
"""Families of scenarios with a steady state below weakening."""
STEADY_FAMILIES: Final = ("torque step", "weakening", "overspeed", *UNWEAKENED_FAMILIES[1:])
"""Families of scenarios with any steady state."""


def unless_sensed(_declaration: Declaration, drive: DriveDocument) -> str | None:
    """Return why a check that is judged with a position sensor does not apply."""
    return None if duty_document(drive).has_sensor else "the drive has no position sensor"


def if_unsensed(record: DutyRecord, share: float) -> float:
    """Return the share of a current or loss that an angle without a sensor may cost; 0 with one (1)."""
    return 0.0 if record.document.has_sensor else share


def undistorted(drive: PmAcDrive, link: float) -> float:
    """Return the greatest peak voltage of a phase that a link gives without distortion (V)."""
    return undistorted_limits(drive, link).voltage


@lru_cache(maxsize=_KEPT)
def greatest_at(drive: PmAcDrive, speed: float, link: float, *, weakens: bool = True) -> SteadyState:
    """Find the steady state of the greatest torque in the sense of rotation, within the limits of current and link."""
    limits = undistorted_limits(drive, link)
    return _in_sense(speed, greatest_within(drive, limits, abs(speed), weakens=weakens))


@lru_cache(maxsize=_KEPT)
def braking_at(drive: PmAcDrive, speed: float, link: float) -> SteadyState:
    """Find the steady state of the greatest torque against the rotation, within the limits of current and link."""
    return _in_sense(speed, braking_within(drive, undistorted_limits(drive, link), abs(speed), weakens=True))


@lru_cache(maxsize=_KEPT)
def least_within(drive: PmAcDrive, speed: float, link: float, torque: float, purpose: Purpose) -> SteadyState:
    """Find the steady state of least current or loss that gives a torque within the limits of current and link."""
    return _least(drive, undistorted_limits(drive, link), speed, torque, purpose)


@lru_cache(maxsize=_KEPT)
def least_free(
    drive: PmAcDrive, speed: float, torque: float, voltage: float = _UNLIMITED_V, purpose: Purpose = "current"
) -> SteadyState:
    """Find the steady state of least current, or loss, for a torque, whatever voltage it takes or within one (V)."""
    return _least(drive, Limits(2.0 * drive.current_limit, voltage), speed, torque, purpose)


def _least(drive: PmAcDrive, limits: Limits, speed: float, torque: float, purpose: Purpose) -> SteadyState:
    aim = LOSS if purpose == "loss" else CURRENT
    state = least_at(drive, limits, abs(speed), sense_of(speed) * torque, aim)
    if not _is_supplied(drive, abs(speed) * state.torque + state.loss):
        # The source or the link limits the currents there, which other checks judge.
        return SteadyState(*(nan for _ in state))
    return _in_sense(speed, state)


def _is_supplied(drive: PmAcDrive, power: float) -> bool:
    """Return True if a link supplies a power, or takes it back (W), with a margin for its regulation."""
    link = drive.dc_link
    if is_ideal(link):
        return True
    least, most = least_power(link, drive.link_voltage), most_power(link, drive.link_voltage)
    return SUPPLIED_SHARE * least <= power <= SUPPLIED_SHARE * most


def _in_sense(speed: float, forward: SteadyState) -> SteadyState:
    """Mirror a steady state of forward rotation where the speed is backward: q current and torque change sign."""
    if speed >= 0.0:
        return forward
    return forward._replace(quadrature=-forward.quadrature, torque=-forward.torque)


def duty_record(record: Record) -> DutyRecord:
    """Take a record for what it is here."""
    assert isinstance(record, DutyRecord), "a check of duty ratios judges runs with duty ratios"
    return record


def worst(margins: Iterable[Margin | None]) -> Margin | None:
    """Return the least of the margins of one run, of those that are there; None without any."""
    known = (margin for margin in margins if margin is not None)
    return min(known, key=lambda margin: margin.value, default=None)


def decisive(judged: Iterable[tuple[PartT, Margin | None]]) -> tuple[PartT, Margin] | None:
    """Return the part of one run with the least margin, of those that have one, and that margin; None without any."""
    known = ((part, margin) for part, margin in judged if margin is not None)
    return min(known, key=lambda pair: pair[1].value, default=None)


def greatest_required(record: DutyRecord, speed: float, link: float) -> float:
    """Return the greatest driving torque with the voltage that a controller must use (N·m); NaN where there is none."""
    voltage, weakens = record.limits.weakening_voltage * link, record.document.weakens
    return greatest_at(record.plant, abs(speed), voltage, weakens=weakens).torque


def is_within_reach(record: DutyRecord, speed: float, link: float, torque: float) -> bool:
    """Return True if a controller must reach a torque at a speed and a link voltage."""
    if torque * speed < 0.0 and not is_ideal(record.plant.dc_link):
        return abs(torque) <= BRAKING_SHARE * abs(braking_at(record.plant, speed, link).torque)
    greatest = greatest_required(record, speed, link)
    return isfinite(greatest) and abs(torque) <= record.limits.weakening * greatest


def at(window: DutyWindow) -> str:
    """State where in a run a window is."""
    return f"at {window.speed / RADIANS_PER_RPM:.5g} rpm, {window.start_s:.4g} to {window.end_s:.4g} s"


def chopper_burns(record: DutyRecord, rows: slice) -> bool:
    """Return True if the chopper's own thresholds swing the link in some control periods, not the controller."""
    return bool(record.run.column("chopper_power")[rows].max() > 0.0)
