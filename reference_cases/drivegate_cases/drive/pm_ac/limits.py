"""What follows from a PM AC drive itself: times to the safe state, ripple of the currents, error of the position."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi, sqrt
from typing import Final

from drivegate_cases.drive.document import Position
from drivegate_cases.drive.usual_values import DriveValues
from drivegate_models.units import RADIANS_PER_RPM

FAILURE_SPEED_SHARE: Final = 0.2
"""Least speed at which something fails, over base speed: below, a phase takes too long to be missed (1)."""
GREATEST_ANGLE_DEG: Final[Mapping[Position, float]] = {
    "exact": 12.0,
    "encoder": 0.0,
    "hall": 2.5,
    "none": 0.0,
}
"""Greatest error by which the angle swings within a turn, by what shows the position (electrical degrees).

A position without edges is judged with errors of its tracks up to this one. That of Hall switches is their usual error
of placement and hysteresis. The edges of an encoder have no errors, and their steps show in no speed.
"""
_SAFE_PERIODS: Final = 1000
_SAFE_MOST_S: Final = 0.1
# What a detector needs: some control periods, and then half a turn of the field, or to see whether the shaft starts to
# turn: a share of the time in which rated torque accelerates it to base speed.
_DETECTION_PERIODS: Final = 100
_DETECTION_TURN: Final = 0.5
_DETECTION_RUN_UP: Final = 0.2
# A speed regulator raises its torque on a shaft that stands: its rate over the control rate, that of its integral over
# it, and the torque over the rated one that no load withstands.
_REGULATED: Final = 0.02
_INTEGRATED: Final = 0.25
_HEAVIEST: Final = 1.2
# Torque over the rated one that is left to turn a shaft past a sector of its Hall switches, where it starts under the
# heaviest load with an angle that is off by half a sector. Until then it looks like a locked one.
_LEFT: Final = 0.1
_SECTORS: Final = 6
_SECONDS: Final = 60.0
# Share of the link voltage that a measured link and rounded duty ratios leave uncertain, and that of the voltage that
# dead time takes.
_UNCERTAIN_LINK: Final = 0.01
_UNCERTAIN_DEAD: Final = 0.5
# Twelfths of link voltage times carrier period over the inductance by which a phase current is beyond its sample.
_SYMMETRIC_TWELFTHS: Final = 1.0
_SAWTOOTH_TWELFTHS: Final = 2.0


def safe_state_s(drive: DriveValues) -> float:
    """Return the longest time from a failure of the electronics or of a sensor to the safe state (s)."""
    turns = drive.machine.pole_pairs * drive.rating.base_speed_rpm / _SECONDS
    return _safe_state_s(drive, _DETECTION_TURN / (FAILURE_SPEED_SHARE * turns))


def safe_state_locked_s(drive: DriveValues) -> float:
    """Return the longest time from that at which the rotor locks to the safe state (s).

    A standing shaft is locked only under more torque than any load, and a speed regulator must raise its torque up to
    that. Of the rate b it requests J b ω at once, and its integral adds J b ω in each 4 / b. On a rotor so light that
    J b ω is less than that torque, this comes before all other times.
    """
    base, torque = drive.rating.base_speed_rpm * RADIANS_PER_RPM, drive.rating.rated_torque_nm
    run_up = drive.machine.inertia_kg_m2 * base / torque
    rate = _REGULATED / float(drive.inverter.control_period_s)
    raised = max(_HEAVIEST / (rate * run_up) - 1.0, 0.0) / (_INTEGRATED * rate)
    return float(raised + _safe_state_s(drive, _DETECTION_RUN_UP * run_up + _sector_s(drive, torque)))


def hides_position(drive: DriveValues, speed_rpm: float, torque_nm: float) -> bool:
    """Return True if the magnet's EMF at a speed is no more than the voltage that is uncertain under a torque.

    That is the whole voltage across the resistance, because a winding may have twice the nominal one, half of the
    voltage that dead time takes, and a share of the link voltage.
    """
    machine, inverter = drive.machine, drive.inverter
    emf = machine.pole_pairs * speed_rpm * RADIANS_PER_RPM * machine.magnet_flux_v_s
    current = torque_nm / (1.5 * machine.pole_pairs * machine.magnet_flux_v_s)
    uncertain = _UNCERTAIN_LINK + _UNCERTAIN_DEAD * inverter.dead_time_s * inverter.carrier_frequency_hz
    return bool(emf <= machine.resistance_ohm * current + uncertain * inverter.link_voltage_v)


def _sector_s(drive: DriveValues, torque: float) -> float:
    """Return how long a shaft that starts may show no edge of its Hall switches (s); 0 without such switches alone."""
    if drive.position != "hall":
        return 0.0
    sector = 2.0 * pi / (_SECTORS * drive.machine.pole_pairs)
    return sqrt(2.0 * sector * drive.machine.inertia_kg_m2 / (_LEFT * torque))


def _safe_state_s(drive: DriveValues, seen_s: float) -> float:
    """Return the longest time from a failure that shows after a time (s) to the safe state (s)."""
    period = float(drive.inverter.control_period_s)
    return max(min(_SAFE_PERIODS * period, _SAFE_MOST_S), _DETECTION_PERIODS * period + seen_s)


def peak_ripple_a(drive: DriveValues) -> float:
    """Return how far a phase current is beyond its sample by the switching of ideal modulation alone (A).

    It is V T / (12 L), with the nominal link voltage V, the carrier period T and the lesser inductance L; twice that
    with a sawtooth carrier; and at most the current limit. The worst voltage is the greatest undistorted one where the
    phase has none itself: duty ratios 0, 1/2 and 1. There its own leg takes it off the mean by V / 3 for half of the
    period. Samples are in the middle of this with a symmetric carrier, and at one end of it with a sawtooth. All kinds
    of modulation have the same there, since both other legs are at the rails.
    """
    inverter, machine = drive.inverter, drive.machine
    twelfths = _SAWTOOTH_TWELFTHS if inverter.carrier == "sawtooth" else _SYMMETRIC_TWELFTHS
    inductance = min(machine.direct_inductance_h, machine.quadrature_inductance_h)
    flux = inverter.link_voltage_v * twelfths / (12.0 * inverter.carrier_frequency_hz)
    return min(float(flux / inductance), float(drive.rating.current_limit_a))
