"""What the terminals show while all legs are off: whether the shaft turns, at which angle and how fast."""

from __future__ import annotations

from math import nan, pi, sqrt
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.duty.flux_observer import argument, place_rotor
from drivegate_models.controllers.duty.plausibility import hold_safe_state

WATCHED_ON: Final = 0
"""The terminals must be watched for longer."""
AT_REST: Final = 1
"""The shaft does not turn; the watch begins again."""
FOLLOWED: Final = 2
"""The shaft turns, and the observer follows it."""

# Control periods in which the terminals are watched, and in which an observer follows a turning shaft that rectifies.
# Speed from which a shaft turns, over the least one, and sum of the currents from which it rectifies, over the limit.
_WATCHED: Final = 60
_FOLLOWED: Final = 300
_TURNS: Final = 0.5
_RECTIFIED: Final = 0.02


@inlined
def reset_watch(state: Any) -> None:
    """Forget what the terminals have shown."""
    state.turned = 0.0
    state.magnitudes = 0.0


@inlined
def turn_off(state: Any, command: Any) -> None:
    """Command all legs off, whose voltage the terminals show from then on."""
    machine = state.machine
    hold_safe_state(machine, command)
    for voltage in (machine.along_voltage, machine.across_voltage):
        voltage[1] = voltage[0]
        voltage[0] = nan


@inlined
def watch_terminals(state: Any, before: tuple[float, float]) -> int:
    """Measure the speed of the terminal voltage, which was `before` in the step before (V); return what it shows.

    The observer begins at the angle and the speed of a shaft that turns.
    """
    machine = state.machine
    along, across = state.along_terminal, state.across_terminal
    size = sqrt(along * along + across * across)
    least = 0.5 * _TURNS * state.least_speed * machine.magnet_flux
    if state.age <= machine.delay + 1 or size <= least:
        reset_watch(state)
    else:
        ahead = before[0] * along + before[1] * across, before[0] * across - before[1] * along
        state.turned += argument(ahead[0], ahead[1])
        state.magnitudes += 1.0
    if state.age < _WATCHED + machine.delay + 1:
        return WATCHED_ON
    if state.magnitudes >= _WATCHED - 1.0:
        speed = state.turned / (state.magnitudes * machine.control_period)
        if state.agreed == 0 and abs(speed) > _TURNS * state.least_speed:
            # The induced voltage is a quarter turn ahead of the magnet in the sense of rotation.
            quarter = 0.5 * pi if speed > 0.0 else -0.5 * pi
            place_rotor(
                state, argument(along, across) - quarter, speed, state.along_before, state.across_before
            )
            state.agreed = 1
    if state.agreed == 1:
        rectified = abs(state.along_before) + abs(state.across_before) > _RECTIFIED * machine.current_limit
        return WATCHED_ON if rectified and state.age < _WATCHED + _FOLLOWED else FOLLOWED
    state.age = machine.delay + 1
    reset_watch(state)
    return AT_REST
