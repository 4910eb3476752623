"""The table `[requirements]` of a PM AC drive: the limits that controllers of its duty ratios are judged by."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import Field

from drivegate_cases.documents.document import Section
from drivegate_cases.documents.wording import significant
from drivegate_cases.drive.limits import SPEED_TOLERANCE, Limit, mechanical_time, times
from drivegate_cases.drive.pm_ac.limits import peak_ripple_a, safe_state_locked_s, safe_state_s
from drivegate_cases.drive.usual_values import DriveValues

SETTLING_PERIODS: Final = 8000
"""Control periods in which a steady state has to be reached, where no time is stated."""
SETTLING_MECHANICAL_TIMES: Final = 3.0
"""Mechanical time constants in which a speed has to settle, where they are longer: a regulator whose reaction to the
swing of the seen speed is limited has a bandwidth of a few of their inverses, and its integral is slower still (1)."""
SETTLING_VOLTAGE_TIMES: Final = 4.0
"""Times in which the link's voltage alone moves the flux of the current limit, where they are longer: what the back-EMF
leaves of the voltage is less (1)."""
_Percent = Annotated[float, Field(gt=0.0, le=1000.0)]
_Ratio = Annotated[float, Field(ge=1.0, le=1000.0)]
_SHARE: Final = times(0.01)
_OF_TORQUE: Final = times(0.01, lambda drive: drive.rating.rated_torque_nm)
_OF_CURRENT: Final = times(0.01, lambda drive: drive.rating.current_limit_a)
_MILLI: Final = times(0.001)


def _control_period_s(drive: DriveValues) -> float:
    return float(drive.inverter.control_period_s)


def _peak_a(stated: float, drive: DriveValues) -> float:
    return _OF_CURRENT(stated, drive) + peak_ripple_a(drive)


def _held_settling_s(drive: DriveValues) -> float:
    """Return the time in which currents and torque of a held shaft settle (s)."""
    machine = drive.machine
    inductance = max(machine.direct_inductance_h, machine.quadrature_inductance_h)
    moved = inductance * drive.rating.current_limit_a / drive.inverter.link_voltage_v
    return max(SETTLING_PERIODS * _control_period_s(drive), significant(SETTLING_VOLTAGE_TIMES * moved, 2))


def _settling_s(drive: DriveValues) -> float:
    """Return the time in which a speed settles (s)."""
    mechanical = significant(SETTLING_MECHANICAL_TIMES * mechanical_time(drive), 2)
    return max(_held_settling_s(drive), mechanical)


class PmAcRequirements(Section):
    """Limits of the checks; one that has a unit follows from the drive where it is left out."""

    settling_s: Annotated[
        float | None,
        Limit("settling_s", otherwise=_settling_s),
        Limit("held_settling_s", otherwise=_held_settling_s),
    ] = Field(
        default=None,
        ge=0.01,
        le=600.0,
        description="time after a change from which on a steady state is judged, by default 8000 control periods or 4 "
        "times in which the link moves the flux of the current limit, or for a speed 3 mechanical time constants "
        "(inertia times base speed over rated torque), whichever is longest",
    )
    speed_tolerance_rpm: Annotated[float | None, SPEED_TOLERANCE] = Field(
        default=None,
        ge=1e-6,
        le=1e6,
        description="greatest error k1 of the mean speed, by default 1 % of base speed",
    )
    torque_tolerance_percent: Annotated[_Percent, Limit("torque_error_nm", _OF_TORQUE)] = Field(
        default=2.0, description="greatest error of the mean torque, in percent of rated torque"
    )
    estimate_tolerance_percent: Annotated[_Percent, Limit("estimate_error_nm", _OF_TORQUE)] = Field(
        default=5.0,
        description="greatest error of the controller's estimate of the mean torque, in percent of rated torque",
    )
    overshoot_percent: Annotated[_Percent, Limit("overshoot", _SHARE)] = Field(
        default=10.0, description="greatest overshoot of the torque, in percent of the reference's step"
    )
    speed_overshoot_percent: Annotated[_Percent, Limit("speed_overshoot", _SHARE)] = Field(
        default=55.0,
        description="greatest overshoot of the speed, in percent of the step that its regulator has to make; with 0.3 "
        "to 2 times the inertia, a symmetrical optimum (a = 2) has 51 %, or 25 % with a set-point filter",
    )
    speed_swing_ratio: Annotated[_Ratio, Limit("speed_swing_ratio")] = Field(
        default=1.5,
        description="greatest swing of the speed in the last part of a steady stretch, over that before; a slow swing "
        "that lasts differs by as much",
    )
    coupled_current_percent: Annotated[_Percent, Limit("coupling", _SHARE)] = Field(
        default=10.0,
        description="greatest movement of the d current by a step of the torque, in percent of the q current's step",
    )
    rise_periods: Annotated[
        float, Field(ge=1.0, le=1e6), Limit("rise_time_s", times(1.0, _control_period_s))
    ] = Field(
        default=12.0,
        description="longest time of a torque step to 90 %, in control periods, plus the time that the link's voltage "
        "needs to move the current",
    )
    peak_current_percent: Annotated[
        float,
        Field(ge=100.0, le=1000.0),
        Limit("peak_a", _peak_a),
        Limit("peak_ripple_a", lambda _, drive: peak_ripple_a(drive)),
    ] = Field(
        default=120.0,
        description="greatest phase current at any time, in percent of the current limit, plus the ripple of ideal "
        "modulation",
    )
    least_current_percent: Annotated[_Percent, Limit("current_excess", _SHARE)] = Field(
        default=2.0,
        description="greatest excess of the current over the least one below weakening, in percent",
    )
    least_loss_percent: Annotated[_Percent, Limit("loss_excess", _SHARE)] = Field(
        default=5.0, description="greatest excess of the loss over the least one, in percent"
    )
    weakening_torque_percent: Annotated[float, Field(gt=0.0, le=100.0), Limit("weakening", _SHARE)] = Field(
        default=95.0,
        description="least torque in weakening, in percent of the greatest within the current limit and "
        "weakening_voltage_percent of the voltage",
    )
    weakening_voltage_percent: Annotated[
        float, Field(ge=50.0, le=100.0), Limit("weakening_voltage", _SHARE)
    ] = Field(
        default=96.0,
        description="voltage in weakening that a controller must use, in percent of the undistorted voltage of the "
        "link; the rest is reserved for its regulators",
    )
    direct_current_percent: Annotated[_Percent, Limit("direct_error_a", _OF_CURRENT)] = Field(
        default=3.0,
        description="greatest distance of the d current from that of most torque per ampere while the voltage is free, "
        "in percent of the current limit",
    )
    braking_torque_percent: Annotated[_Percent, Limit("braking", _SHARE)] = Field(
        default=10.0,
        description="greatest braking torque after a torque reference goes to zero, in percent of the step of the "
        "torque, or of rated torque if that is more",
    )
    safe_state_ms: Annotated[
        _Ratio | None,
        Limit("safe_state_s", _MILLI, otherwise=safe_state_s),
        Limit("safe_state_locked_s", _MILLI, otherwise=safe_state_locked_s),
    ] = Field(
        default=None,
        description="longest time from a failure to the safe state, in milliseconds, by default 1000 control periods, "
        "at most 100 ms, but no less than the failure needs to show",
    )
    failure_torque_percent: Annotated[_Percent, Limit("failure_torque_nm", _OF_TORQUE)] = Field(
        default=20.0,
        description="greatest torque beyond the reference after a failure, and in the safe state, in percent of rated "
        "torque",
    )
    dead_time_ripple: Annotated[_Ratio, Limit("dead_time_ripple")] = Field(
        default=2.0, description="greatest torque ripple with dead time at low speed, over that without"
    )
    modulation_ripple: Annotated[_Ratio, Limit("modulation_ripple")] = Field(
        default=1.2, description="greatest torque ripple over that of ideal modulation on the same drive"
    )
    source_current_percent: Annotated[float, Field(ge=100.0, le=1000.0), Limit("source_current", _SHARE)] = (
        Field(
            default=105.0,
            description="greatest mean current of the source over 10 ms, in percent of charge_limit_a and "
            "discharge_limit_a",
        )
    )
    link_braking_percent: Annotated[float, Field(gt=0.0, le=100.0), Limit("link_braking", _SHARE)] = Field(
        default=80.0,
        description="least braking torque on a link with a capacitor, in percent of the greatest that it allows",
    )
    link_swing_percent: Annotated[_Percent, Limit("link_swing", _SHARE)] = Field(
        default=2.0,
        description="greatest swing of the link in steady state, peak to peak, in percent of its nominal voltage",
    )
    temperature_rise_percent: Annotated[
        float, Field(ge=100.0, le=200.0), Limit("temperature_rise", _SHARE)
    ] = Field(
        default=102.0,
        description="greatest rise of the windings' temperature above ambient_c, in percent of that to limit_c",
    )
    derated_current_percent: Annotated[float, Field(ge=100.0, le=200.0), Limit("derated_current", _SHARE)] = (
        Field(
            default=105.0,
            description="greatest current of windings at their limit, in percent of what they bear for good",
        )
    )
    derated_torque_percent: Annotated[float, Field(gt=0.0, le=100.0), Limit("derated_torque", _SHARE)] = (
        Field(
            default=50.0,
            description="least torque of windings at their limit, in percent of what they bear for good",
        )
    )
    derating_step_percent: Annotated[_Percent, Limit("derating_step_nm", _OF_TORQUE)] = Field(
        default=10.0,
        description="greatest change of the torque under a constant reference from one mean over 10 ms to the next, in "
        "percent of rated torque",
    )


NO_PM_AC_REQUIREMENTS = PmAcRequirements()
"""Limits that follow from the drive alone."""
