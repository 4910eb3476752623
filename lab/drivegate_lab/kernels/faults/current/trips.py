"""Faults that limit the drive's current or angle: for heat, for peaks, and after a single sample."""

from __future__ import annotations

from typing import Any, Final

from drivegate_lab.kernels.faults.broken_coupling import breaks_away
from drivegate_lab.kernels.faults.current import state as faults
from drivegate_models.compilation.kernels import inlined

# Share of the current sum at rated power and nominal supply voltage: rated power exceeds it at any speed.
_UNDER_LOAD: Final = 0.8
_DERATED_SHARE: Final = 0.2
_HALF_CYCLE: Final = 0.25
# Share of the current limit up to which a current reference counts as none.
_IDLE_SHARE: Final = 0.01
# Control periods over which an acceleration is measured.
_MEASURED_OVER: Final = 8.0


@inlined
def _count_idling(state: Any, reference: float) -> None:
    """Latch once a turning shaft has had no current reference (A) for some time; it has had one before."""
    if reference > _IDLE_SHARE * state.controller.current_limit:
        state.tally = 1
        state.memory = 0.0
    elif state.tally == 1 and state.sense.speed_reference > 0.0:
        state.memory += state.controller.control_period
    if state.memory >= state.size:
        state.latched = 1


@inlined
def _trips_on_the_way(state: Any, fault: int) -> bool:
    """Update the fault's state, and return True if a reference, or the way to it, has been one that it trips at."""
    if fault == faults.BEYOND_TRIPS:
        reference = state.sense.speed_reference
        if reference != state.memory and min(reference, state.memory) > state.size:
            state.latched = 1
        state.memory = reference
    elif fault == faults.IDLE_TRIPS:
        _count_idling(state, state.late_reference)
    elif fault == faults.BREAKING_AWAY_TRIPS:
        sense = state.sense
        if breaks_away(state.shaft, sense.speed, sense.speed_reference, state.size, _MEASURED_OVER):
            state.latched = 1
    else:
        return False
    return bool(state.latched == 1)


@inlined
def is_derated(state: Any, fault: int) -> bool:
    """Update the fault's state, and return True if the current is to be limited further."""
    sense, controller = state.sense, state.controller
    period = controller.control_period
    loaded = sense.current_magnitude_sum > _UNDER_LOAD * controller.rated_sum
    if fault == faults.HEAT_KEPT:
        state.memory += period if loaded else 0.0
        return bool(state.memory >= state.size)
    if fault == faults.HEAT_IN_STEPS:
        state.tally += 1 if loaded else 0
        return bool(state.tally >= state.size)
    if fault == faults.DERATES_IN_TURNS:
        state.memory += period if loaded else 0.0
        return bool(state.memory >= state.size and sense.time % (2.0 * _HALF_CYCLE) < _HALF_CYCLE)
    if fault == faults.PEAK_TRIPS:
        state.memory = state.memory + period if state.late_reference >= controller.current_limit else 0.0
        if state.memory >= state.size:
            state.latched = 1
    elif fault == faults.SWELL_TRIPS:
        if sense.half_supply_voltage > state.size * controller.nominal_voltage:
            state.latched = 1
    elif fault == faults.OVERSPEED_TRIPS:
        if sense.speed > state.size * sense.speed_reference:
            state.latched = 1
    elif fault == faults.LOST_SPEEDS_COUNTED:
        state.tally += 1 if sense.speed <= 0.0 else 0
        return bool(state.tally >= state.size)
    else:
        return False
    return bool(state.latched == 1)


@inlined
def derate(state: Any, fault: int, command: Any) -> None:
    """Limit the current reference further if the fault has tripped."""
    derated = is_derated(state, fault) or _trips_on_the_way(state, fault)
    if fault in (faults.PEAK_TRIPS, faults.IDLE_TRIPS):
        state.late_reference = command.current_reference
    if derated:
        limit = _DERATED_SHARE * state.controller.current_limit
        command.current_reference = min(command.current_reference, limit)


@inlined
def end_advance(state: Any, fault: int, command: Any) -> None:
    """Set the angle to zero permanently if the fault has tripped."""
    if fault == faults.LOST_CURRENT_TRIPS:
        if state.true_sum < state.extent and state.memory > state.size:
            state.latched = 1
        state.memory = state.true_sum
    elif fault == faults.STOP_LATCHES:
        if state.sense.speed_reference <= 0.0:
            state.latched = 1
    elif fault == faults.IDLE_LATCHES:
        _count_idling(state, command.current_reference)
    else:
        return
    if state.latched == 1:
        command.advance_angle = 0.0
