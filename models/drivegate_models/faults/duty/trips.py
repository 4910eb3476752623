"""Faults that turn the bridge off for good where nothing has failed."""

from __future__ import annotations

from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.faults.duty.changes import largest_current

# Share of a current that is left of one that has vanished, and the number of swings of a loose sensor.
_LEFT: Final = 0.01
_SWINGS: Final = 40
# Control periods over which an acceleration is measured; distances from a new reference, relative to it, beyond which
# the shaft is on its way to it, and up to which it has come to it (1).
_MEASURED_OVER: Final = 32.0
_ON_ITS_WAY: Final = 0.1
_ARRIVED: Final = 0.01


@inlined
def _vanishes(state: Any, sense: Any) -> bool:
    """Return True if all currents have vanished since the preceding step, once more often than is borne."""
    largest = largest_current(sense)
    before = state.current_before
    state.current_before = largest
    if before > state.vanishing_current > 0.0 and largest < _LEFT * before:
        state.vanishings += 1
    return bool(state.vanishings > state.vanishings_borne)


@inlined
def _swings(state: Any, sense: Any) -> bool:
    """Return True if the speed has swung about its mean for some time."""
    away = sense.speed - state.mean_speed
    if abs(away) > state.loose_swing * abs(state.mean_speed) > 0.0:
        side = 1.0 if away > 0.0 else -1.0
        if side != state.swing_side:
            state.swings += 1
        state.swing_side = side
    return bool(state.swings >= _SWINGS)


@inlined
def _outruns_itself(state: Any, sense: Any) -> bool:
    """Return True if the shaft leaves its reference faster than it ever came to one."""
    state.speed_lagging += (sense.speed - state.speed_lagging) / _MEASURED_OVER
    acceleration = abs(sense.speed - state.speed_lagging) / (_MEASURED_OVER * state.control_period)
    distance = abs(sense.reference - sense.speed)
    if sense.reference != state.reference_sought:
        state.reference_sought = sense.reference
        state.is_on_its_way = 1 if distance > _ON_ITS_WAY * abs(sense.reference) else 0
    elif distance <= _ARRIVED * abs(sense.reference):
        state.is_on_its_way = 0
    if state.is_on_its_way == 1:
        state.acceleration_seen = max(state.acceleration_seen, acceleration)
        return False
    return bool(acceleration > state.outrunning * state.acceleration_seen > 0.0)


@inlined
def mistakes_samples(state: Any, sense: Any) -> bool:
    """Return True if samples of a healthy drive count as a failure."""
    return _vanishes(state, sense) or _swings(state, sense) or _outruns_itself(state, sense)
