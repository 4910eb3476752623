"""Faults that turn the bridge off for good where nothing has failed."""

from __future__ import annotations

from typing import Any, Final

from drivegate_lab.kernels.faults.broken_coupling import breaks_away
from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.duty.current_regulator import largest_current

# Share of a current that is left of one that has vanished, and the number of swings of a loose sensor.
_LEFT: Final = 0.01
_SWINGS: Final = 40
# Control periods over which an acceleration is measured.
_MEASURED_OVER: Final = 32.0


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
def mistakes_samples(state: Any, sense: Any) -> bool:
    """Return True if samples of a healthy drive count as a failure."""
    if state.breaking_away > 0.0 and breaks_away(
        state.shaft, sense.speed, sense.reference, state.breaking_away, _MEASURED_OVER
    ):
        return True
    return _vanishes(state, sense) or _swings(state, sense)
