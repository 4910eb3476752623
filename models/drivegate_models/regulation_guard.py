"""What the designs share below their searches: which sensors to believe, and whether the speed is regulated.

A signal that jumps by more than the drive can do is not believed for a while. Regulation is judged by the
smoothed speed error and by a current reference that stays at its limit.
"""

from __future__ import annotations

from math import pi
from typing import Any, Final

from drivegate_models.compilation import unfused

CALM: Final = 0
"""Nothing to report."""
CHANGED: Final = 1
"""Speed reference or supply has changed."""
STARVED: Final = 2
"""The current reference is at its limit and the speed does not return, or hardly."""
ALARMED: Final = 3
"""The speed stays behind, more than at an angle that keeps the torque."""
RELIEVED: Final = 4
"""The speed is ahead, more than a slewing angle explains: the load has fallen."""

UNEASY: Final = 0.7 * pi / 30.0
"""Smoothed speed error that a regulated drive keeps within (rad/s)."""

_ALARM = 1.5 * pi / 30.0
_RELIEF = 1.2 * pi / 30.0
_ALARM_DWELL = 0.006
_SMOOTHING = 0.004
_SUPPLY_SMOOTHING = 0.004
_SUPPLY_MOVED = 0.008
_GREATEST_JUMP = 10.0 * pi / 30.0
_LEAST_SHARE = 0.4
_PATIENCE = 0.04
_BLIND = 0.06
_BELIEVED_FROM = 2.0


@unfused
def believe_sensors(state: Any, speed: float, voltage: float, current_sum: float) -> None:
    """Take over the sensors' values, but not at once those that jump.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated; `blind` counts down the control periods in which nothing may be concluded.
    speed : float
        Measured speed (rad/s).
    voltage : float
        Measured voltage of a half-source (V).
    current_sum : float
        Measured sum of current magnitudes (A).
    """
    patience = _PATIENCE / state.control_period
    blind = round(_BLIND / state.control_period)
    state.blind = max(state.blind - 1, 0)
    if abs(speed - state.speed) > _GREATEST_JUMP and state.speed_doubted < patience:
        state.speed_doubted += 1
        state.blind = blind
    else:
        state.speed = speed
        state.speed_doubted = 0
    if voltage < _LEAST_SHARE * state.voltage and state.voltage_doubted < patience:
        state.voltage_doubted += 1
        state.blind = blind
    else:
        state.voltage += (voltage - state.voltage) * min(state.control_period / _SUPPLY_SMOOTHING, 1.0)
        state.voltage_doubted = 0
    expected = state.current_sum > _BELIEVED_FROM
    if expected and current_sum < _LEAST_SHARE * state.current_sum and state.current_doubted < patience:
        state.current_doubted += 1
    else:
        state.current_sum = current_sum
        state.current_doubted = 0


@unfused
def forget_alarms(state: Any) -> None:
    """Begin to judge regulation anew.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    """
    state.alarm_run = 0
    state.relief_run = 0
    state.saturated_run = 0


@unfused
def watch_regulation(state: Any, speed_reference: float, saturated: bool) -> int:
    """Judge regulation after one control period.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    speed_reference : float
        (rad/s).
    saturated : bool
        Whether the current reference is at its limit.

    Returns
    -------
    int
        `CALM`, `CHANGED`, `STARVED`, `ALARMED` or `RELIEVED`.
    """
    error = speed_reference - state.speed
    state.error += (error - state.error) * min(state.control_period / _SMOOTHING, 1.0)
    moved = abs(state.voltage - state.supply) > _SUPPLY_MOVED * state.nominal_voltage
    if speed_reference != state.speed_reference or (moved and state.blind == 0):
        state.speed_reference = speed_reference
        state.supply = state.voltage
        forget_alarms(state)
        return CHANGED
    if state.blind > 0:
        forget_alarms(state)
        return CALM
    state.saturated_run = state.saturated_run + 1 if saturated and error > 0.0 else 0
    if state.saturated_run == 1:
        state.speed_mark = state.speed
    if state.saturated_run * state.control_period >= state.starving_dwell:
        state.saturated_run = 0
        if (
            state.speed <= state.speed_mark + state.slowest_regain * state.starving_dwell
            and state.error > _ALARM
        ):
            return STARVED
    state.alarm_run = state.alarm_run + 1 if state.error > _ALARM else 0
    if state.alarm_run * state.control_period >= _ALARM_DWELL:
        state.alarm_run = 0
        return ALARMED
    state.relief_run = state.relief_run + 1 if state.error < -_RELIEF else 0
    if state.relief_run * state.control_period >= _ALARM_DWELL:
        state.relief_run = 0
        return RELIEVED
    return CALM
