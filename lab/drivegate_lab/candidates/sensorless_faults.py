"""Faulty controllers without a position sensor, and the checks that catch them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import radians
from typing import Any, Final

from drivegate.contracts.duty.checks.judged import SENSORLESS_ANGLE_DEG
from drivegate.contracts.duty.document import duty_document
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_lab.candidates.faults.seeded_fault import FaultOnDrive, SeededFault
from drivegate_lab.kernels.faults.duty import sensorless as faults
from drivegate_models.units import RADIANS_PER_RPM

Alter = Callable[[Any], None]
"""Changes the record of a controller's state, just reset."""


@dataclass(frozen=True)
class SensorlessFault(SeededFault):
    """A fault of `foc-sensorless`, by a changed constant or by what is wrong in its steps."""

    base: str = "foc-sensorless"
    kind: str = "Without a position sensor"
    variation: int = 0
    """What its steps do wrong, from `drivegate_lab.kernels.faults.duty.sensorless`."""
    alter: Alter | None = None

    def check_on(self, drive: DriveDocument) -> str:
        """Return the check that must catch the fault; a small voltage left out turns the angle alone."""
        document = duty_document(drive)
        if self.alter is _no_resistance and not document.has_sensor:
            return self.check if _resistive_share(document) >= _LOST_SHARE else "SLS-3"
        return self.check

    def on(self, drive: DriveDocument) -> FaultOnDrive:
        """Return what the fault is on a drive; it is tried only where nothing shows the shaft."""
        document = duty_document(drive)
        because = "this drive has a position sensor" if document.has_sensor else self._idle_because(document)
        return FaultOnDrive(self.check_on(drive), self.sentence, "", because)

    def _idle_because(self, drive: PmAcDocument) -> str | None:
        if drive.one_way_because is not None and self.variation in _BACKWARD:
            return str(drive.one_way_because)
        if self.alter in (_long_dead_time, _no_dead_time) and drive.inverter.dead_time_s == 0.0:
            return "this drive has no dead time"
        if self.variation in _FOUND_AGAIN and _least_electrical(drive) > _FAST:
            return "at the least speed of this drive the observer finds a lost rotor again at once"
        if self.variation not in _TURNED:
            return None
        electrical = drive.machine.pole_pairs * drive.rating.highest_speed_rpm * RADIANS_PER_RPM
        turned = _TURNED[self.variation] * electrical * drive.control_period_s
        return (
            None
            if turned > 1.1 * _ALLOWED
            else "at the highest speed of this drive it costs too little angle"
        )


# Error of the angle over what the shaft turns in a control period (1), and the greatest one (electrical rad).
_TURNED: Final = {faults.NEWER_VOLTAGE: 0.56, faults.LATE_ANGLE: 1.0}
_ALLOWED: Final = radians(SENSORLESS_ANGLE_DEG)
_FOUND_AGAIN: Final = frozenset({faults.HALF_TURN_OFF, faults.STALL_BELIEVED})
# Least speed from which on the observer finds a lost rotor again (electrical rad/s), and share of its EMF from which on
# the voltage across the resistance, left out, loses the rotor; less turns the angle alone.
_FAST: Final = 250.0
_LOST_SHARE: Final = 0.5
_BACKWARD: Final = frozenset(
    {faults.UNSIGNED_GAIN, faults.STARTS_FORWARD, faults.TURNS_FORWARD, faults.COASTS}
)


def _least_electrical(drive: PmAcDocument) -> float:
    return drive.machine.pole_pairs * drive.least_speed_rpm * RADIANS_PER_RPM


def _resistive_share(drive: PmAcDocument) -> float:
    """Return the voltage across the resistance over the EMF, at the least speed and 80 % of rated torque."""
    machine = drive.machine
    current = 0.8 * drive.rating.rated_torque_nm / (1.5 * machine.pole_pairs * machine.magnet_flux_v_s)
    return machine.resistance_ohm * current / (_least_electrical(drive) * machine.magnet_flux_v_s)


def _no_resistance(state: Any) -> None:
    state["machine"]["resistance"] = 0.0


def _no_dead_time(state: Any) -> None:
    state["machine"]["dead_ratio"] = 0.0


def _long_dead_time(state: Any) -> None:
    state["machine"]["dead_ratio"] *= 5.0


def _weak_start(state: Any) -> None:
    state["start_current"] *= 0.3


def _slow_speed_regulator(state: Any) -> None:
    # Slow enough for half of rated torque to stop a shaft of any included drive.
    state["machine"]["speed_gain"] *= 0.05
    state["machine"]["speed_integral_step"] *= 0.05 * 0.05


def _slow_observer(state: Any) -> None:
    state["bandwidth"] *= 0.05


def _fault(check: str, sentence: str, variation: int = 0, alter: Alter | None = None) -> SensorlessFault:
    return SensorlessFault("", sentence, check, variation=variation, alter=alter)


_UNNAMED: Final = {
    "observer-without-resistance": _fault(
        "SLS-2", "Leaves the voltage across the resistance out of its observer.", alter=_no_resistance
    ),
    "long-dead-time-assumed": _fault(
        "SLS-2", "Compensates for five times the dead time, which its observer misses.", alter=_long_dead_time
    ),
    "dead-time-left-out": _fault(
        "SLS-3",
        "Takes its commands for the voltage that acts, and leaves the dead time out.",
        alter=_no_dead_time,
    ),
    "observer-voltage-too-new": _fault(
        "SLS-3", "Observes the voltage of the answer after the one that acted.", faults.NEWER_VOLTAGE
    ),
    "angle-negated": _fault(
        "SLS-3", "Reports the angle with the sign of the other sense.", faults.ANGLE_NEGATED
    ),
    "observer-gain-signed": _fault(
        "SLS-2", "Has an observer whose gain grows with the signed speed.", faults.UNSIGNED_GAIN
    ),
    "standstill-presumed": _fault("SLS-6", "Starts every shaft as one at rest.", faults.STANDSTILL_PRESUMED),
    "start-for-ever": _fault(
        "SLS-7",
        "Turns its current vector for ever before a rotor that does not follow.",
        faults.FIELD_FOR_EVER,
    ),
    "loss-untold": _fault("SLS-7", "Turns its bridge off without a fault code.", faults.LOSS_UNTOLD),
    "angle-reported-late": _fault(
        "SLS-3", "Reports the angle of the preceding control period.", faults.LATE_ANGLE
    ),
    "electrical-angle-reported": _fault(
        "SLS-3", "Reports the electrical angle as that of the shaft.", faults.ELECTRICAL_ANGLE
    ),
    "handover-half-a-turn-off": _fault(
        "SLS-1", "Hands over to an observer that is half a turn off.", faults.HALF_TURN_OFF
    ),
    "handover-without-torque": _fault(
        "SLS-1",
        "Hands over to a slow speed regulator that begins without a torque.",
        faults.FROM_ZERO,
        _slow_speed_regulator,
    ),
    "stall-believed": _fault(
        "SLS-7", "Drives a rotor that stands still as long as the flux is right.", faults.STALL_BELIEVED
    ),
    "coasts-to-reverse": _fault(
        "SLS-5", "Lets a shaft coast whose reference has changed its sense.", faults.COASTS
    ),
    "starts-forward-only": _fault("SLS-1", "Starts forward whatever the reference.", faults.STARTS_FORWARD),
    "forward-presumed": _fault(
        "SLS-6", "Takes every shaft that turns for turning forward.", faults.TURNS_FORWARD
    ),
    "weak-start": _fault("SLS-1", "Starts with 30 % of the current that a start has.", alter=_weak_start),
    "slow-observer": _fault(
        "SLS-4", "Has an observer with a twentieth of the bandwidth.", alter=_slow_observer
    ),
}

SENSORLESS_FAULTS: Final = {name: replace(fault, name=name) for name, fault in _UNNAMED.items()}
"""All of them, by the name behind ``faulty:``."""
