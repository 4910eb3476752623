"""Faulty controllers of duty ratios after reports from the field: each shows in an operation that is rarely tried."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final, TypeAlias

from drivegate.contracts.duty.scenarios.rare import LONG_RATE_HZ
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_lab.candidates.faults.seeded_fault import NEEDS_ANGLE, FaultOnDrive, SeededFault
from drivegate_lab.kernels.faults.duty.field import state as faults
from drivegate_models.contract.duty.signals import SPEED_REFERENCE, TORQUE_REFERENCE, DutyNameplate

Amount: TypeAlias = float | Callable[[DutyNameplate], float]
"""A number, or what it follows from on a drive."""

_MICROSECONDS: Final = 1e-6
_MILLISECONDS: Final = 1e-3


@dataclass(frozen=True)
class FieldFault(SeededFault):
    """A fault that is more than a changed constant; its kind is the operation that shows it."""

    base: str = "foc"
    fault: int = 0
    """What its steps do wrong, from `drivegate_lab.kernels.faults.duty.field.state`."""
    size: Amount = 0.0
    extent: Amount = 0.0
    """How large the fault is, in the units that the fault has."""
    under: int | None = None
    """The one kind of reference under which it acts; None for all."""
    needs_weakening: bool = False
    needs_ideal_link: bool = False

    def on(self, drive: DriveDocument) -> FaultOnDrive:
        """Return what the fault is on a drive; it idles where the drive has no such operation."""
        idle = None
        if self.needs_weakening and isinstance(drive, PmAcDocument) and not drive.weakens:
            idle = "this drive does not weaken its field"
        if self.needs_ideal_link and isinstance(drive, PmAcDocument) and drive.real_link is not None:
            idle = "STP-1 judges steps of an ideal link alone"
        if drive.position == "none":
            idle = NEEDS_ANGLE
        return FaultOnDrive(self.check, self.sentence, self.kind, idle)

    def sizes_on(self, plate: DutyNameplate) -> tuple[float, float]:
        """Return size and extent for a nameplate."""
        size, extent = (amount(plate) if callable(amount) else amount for amount in (self.size, self.extent))
        return size, extent


def _rated_torque(share: float) -> Callable[[DutyNameplate], float]:
    return lambda plate: share * plate.rated_power / plate.base_speed


def _rated_power(share: float) -> Callable[[DutyNameplate], float]:
    return lambda plate: share * plate.rated_power


def _base_speed(share: float) -> Callable[[DutyNameplate], float]:
    return lambda plate: share * plate.base_speed


def _current_limit(share: float) -> Callable[[DutyNameplate], float]:
    return lambda plate: share * plate.current_limit


def _periods(count: float) -> Callable[[DutyNameplate], float]:
    return lambda plate: count * plate.control_period


def _fault(
    check: str,
    sentence: str,
    fault: int,
    size: Amount = 0.0,
    extent: Amount = 0.0,
    under: int | None = None,
    *,
    needs_weakening: bool = False,
    needs_ideal_link: bool = False,
) -> FieldFault:
    return FieldFault(
        "",
        sentence,
        check,
        fault=fault,
        size=size,
        extent=extent,
        under=under,
        needs_weakening=needs_weakening,
        needs_ideal_link=needs_ideal_link,
    )


_OF_KINDS: Final = {
    "torque that falls at the voltage limit": {
        "fall-at-limit-missed": _fault(
            "ACC-1",
            "Keeps a torque that it could not reach until the reference is zero.",
            faults.FALL_MISSED,
            _rated_power(1.3),
            under=TORQUE_REFERENCE,
            needs_weakening=True,
        ),
        "weakening-kept-after-fall": _fault(
            "FWK-2",
            "Weakens by 15 % of the current limit after a torque that it could not reach, until the reference is zero.",
            faults.WEAKENING_KEPT_AFTER_FALL,
            _rated_power(1.3),
            _current_limit(0.15),
            under=TORQUE_REFERENCE,
            needs_weakening=True,
        ),
    },
    "stop from deep weakening": {
        "weakening-kept-through-stop": _fault(
            "FWK-2",
            "Weakens below base speed too, by 20 % of the current limit, once it has stopped from above base speed.",
            faults.WEAKENING_KEPT_THROUGH_STOP,
            _base_speed(1.2),
            _current_limit(0.2),
            needs_weakening=True,
        ),
        "torque-cut-after-stop": _fault(
            "ACC-1",
            "Takes a stop from above base speed for an emergency, and limits the torque to 30 % after it.",
            faults.TORQUE_CUT_AFTER_STOP,
            _base_speed(1.2),
            _rated_torque(0.3),
            needs_weakening=True,
        ),
    },
    "clocks": {
        "speed-ramp-of-signed-microseconds": _fault(
            "ACC-1",
            "Ramps a speed reference up by microseconds that are negative after 36 minutes.",
            faults.CLOCK_NEGATIVE,
            2.0**32 * _MICROSECONDS,
            under=SPEED_REFERENCE,
        ),
        "microseconds-leap": _fault(
            "ACC-1",
            "Integrates the speed error over minus 72 minutes where its microseconds wrap around.",
            faults.CLOCK_LEAPS,
            2.0**32 * _MICROSECONDS,
            under=SPEED_REFERENCE,
        ),
        "milliseconds-signed": _fault(
            "ACC-1",
            "Ramps its reference up by milliseconds in 32 bits, negative after 25 days.",
            faults.CLOCK_NEGATIVE,
            2.0**32 * _MILLISECONDS,
        ),
        "milliseconds-of-16-bits": _fault(
            "ACC-1",
            "Ramps its reference up again where milliseconds in 16 bits wrap around.",
            faults.CLOCK_RESTARTS,
            2.0**16 * _MILLISECONDS,
            0.1,
        ),
        "milliseconds-of-24-bits": _fault(
            "ACC-1",
            "Ramps its reference up again where a sum of milliseconds has more bits than a float.",
            faults.CLOCK_RESTARTS,
            2.0**24 * _MILLISECONDS,
            0.1,
        ),
        "milliseconds-of-15-bits": _fault(
            "ACC-1",
            "Ramps its torque reference up by milliseconds in 16 bits with a sign.",
            faults.CLOCK_NEGATIVE,
            2.0**16 * _MILLISECONDS,
            under=TORQUE_REFERENCE,
        ),
        "periods-of-16-bits": _fault(
            "ACC-1",
            "Ramps its reference up again where a count of control periods in 16 bits wraps around.",
            faults.CLOCK_RESTARTS,
            _periods(2.0**16),
            0.1,
        ),
        "periods-of-32-bits": _fault(
            "ACC-1",
            "Ramps its reference up by a signed count of control periods in 32 bits.",
            faults.CLOCK_NEGATIVE,
            _periods(2.0**32),
        ),
        "periods-signed-of-16-bits": _fault(
            "ACC-1",
            "Ramps a speed reference up by a signed count of control periods in 16 bits.",
            faults.CLOCK_NEGATIVE,
            _periods(2.0**16),
            under=SPEED_REFERENCE,
        ),
        "soft-start-after-72-minutes": _fault(
            "ACC-1",
            "Ramps its torque reference up again over a second where microseconds in 32 bits wrap around.",
            faults.CLOCK_RESTARTS,
            2.0**32 * _MICROSECONDS,
            1.0,
            under=TORQUE_REFERENCE,
        ),
        "time-in-single-precision": _fault(
            "ACC-1",
            "Extrapolates its angle by a time in seconds in single precision.",
            faults.CLOCK_COARSE,
            1.0,
        ),
    },
    "small references": {
        "small-torques-dropped": _fault(
            "ACC-1",
            "Takes torque references below 6 % of rated torque for zero.",
            faults.SMALL_DROPPED,
            _rated_torque(0.06),
            under=TORQUE_REFERENCE,
        ),
        "small-braking-dropped": _fault(
            "ACC-1",
            "Takes braking references below 6 % of rated torque for zero.",
            faults.SMALL_BRAKING_DROPPED,
            _rated_torque(0.06),
            under=TORQUE_REFERENCE,
        ),
    },
    "hoist at zero speed": {
        "parks-at-zero-speed": _fault(
            "ACC-1",
            "Turns its bridge off at rest after 20 ms with a reference of zero.",
            faults.PARKS_AT_ZERO,
            lambda plate: 0.02 / plate.control_period,
            under=SPEED_REFERENCE,
        ),
        "integral-leaks-at-zero-speed": _fault(
            "ACC-1",
            "Lets the integral of the speed leak away at a reference of zero.",
            faults.LEAKS_AT_ZERO,
            lambda plate: plate.control_period / 0.05,
            under=SPEED_REFERENCE,
        ),
    },
    "rated torque under a speed reference": {
        "driving-torque-limited": _fault(
            "ACC-1",
            "Limits its driving torque under a speed reference to 95 % of rated torque.",
            faults.DRIVING_LIMITED,
            _rated_torque(0.95),
            under=SPEED_REFERENCE,
        ),
    },
    "lowering a rated load": {
        "lowering-torque-limited": _fault(
            "ACC-1",
            "Limits its braking torque under a speed reference to 95 % of rated torque.",
            faults.LOWERING_LIMITED,
            _rated_torque(0.95),
            under=SPEED_REFERENCE,
        ),
    },
    "repeated lost samples": {
        "tenth-lost-sample-trips": _fault(
            "ROB-5",
            "Turns its bridge off at the tenth lost sample since its start.",
            faults.LOST_SAMPLES_COUNTED,
            10.0,
        ),
        "lost-samples-averaged": _fault(
            "ROB-5",
            "Takes each lost sample of the currents into the offset of its first sensor, by 0.5 % of the limit.",
            faults.LOST_SAMPLES_AVERAGED,
            _current_limit(0.005),
        ),
    },
    "link steps while braking at top speed": {
        "sag-ends-braking": _fault(
            "ACC-1",
            "Turns its bridge off at 90 % of the link's voltage while it brakes far above base speed.",
            faults.LINK_SAG_TRIPS,
            _base_speed(1.2),
            lambda plate: 0.9 * plate.supply_voltage,
            under=TORQUE_REFERENCE,
        ),
    },
    "link steps below base speed": {
        "link-filtered": _fault(
            "STP-1",
            "Measures the link's voltage through a filter of 20 ms.",
            faults.LINK_FILTERED,
            0.02,
            needs_ideal_link=True,
        ),
    },
    "minutes": {
        "offset-creeps": _fault(
            "RIP-4",
            "Tracks the offset of its first current sensor by a sum that creeps by 3 % of the limit in a minute.",
            faults.OFFSET_CREEPS,
            lambda plate: 0.03 * plate.current_limit / 60.0,
        ),
        "winding-modelled-too-small": _fault(
            "ACC-1",
            "Halves its torque by a model of a winding that rated torque overheats within a minute.",
            faults.HEATS_UP,
            # Runs of minutes are shorter at a high rate.
            lambda plate: min(60.0, 60.0 * LONG_RATE_HZ * plate.control_period),
            _rated_torque(0.5),
        ),
        "angle-of-summed-turns": _fault(
            "FWK-2",
            "Adds all turns up in single precision, and takes its angle from this sum.",
            faults.TURNS_SUMMED,
        ),
    },
    "transients of the speed": {
        "integral-cleared-at-reference": _fault(
            "ROB-4",
            "Clears the integral of the speed at each new reference.",
            faults.INTEGRAL_CLEARED,
            under=SPEED_REFERENCE,
        ),
    },
    "large torque steps": {
        "torque-slewed": _fault(
            "STP-1",
            "Changes its torque reference by 2.5 % of rated torque in a control period.",
            faults.TORQUE_SLEWED,
            _rated_torque(0.025),
            under=TORQUE_REFERENCE,
        ),
    },
    "load that is gone for a moment": {
        "integral-winds-up-without-load": _fault(
            "ROB-4",
            "Never brakes under a speed reference, and integrates on meanwhile.",
            faults.WINDS_UP,
            under=SPEED_REFERENCE,
        ),
    },
}

FIELD_FAULTS: Final = {
    name: replace(fault, name=name, kind=kind)
    for kind, named in _OF_KINDS.items()
    for name, fault in named.items()
}
"""All of them, by the name behind ``faulty:``."""
