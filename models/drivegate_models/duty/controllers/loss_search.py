"""The currents of least loss, by trying: the one along the magnet's axis moves to where the link gives less power."""

from __future__ import annotations

from math import isnan, nan
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined

SETTLING: Final = 0.03
"""Time that a new current is given before the power is looked at (s)."""
LOOKING: Final = 0.02
"""Time over which the power is averaged (s)."""

# First and last step over the current limit.
_FIRST_STEP = 0.06
_LAST_STEP = 0.002
# Change of torque over the greatest one, and of speed over itself, from which on the point of operation is another.
_OTHER_TORQUE = 0.02
_OTHER_SPEED = 0.02


@inlined
def forget_search(state: Any, torque: float, speed: float) -> None:
    """Begin a search anew at a torque (N m) and a speed (rad/s)."""
    state.search_torque = torque
    state.search_speed = speed
    state.search_offset = 0.0
    state.search_step = -_FIRST_STEP * state.current_limit
    state.search_count = 0
    state.search_sum = 0.0
    state.search_power = nan


@inlined
def _move(state: Any, power: float) -> None:
    """Take the next step: on while the power falls, else back and half as far."""
    if not isnan(state.search_power) and power >= state.search_power:
        state.search_step *= -0.5
        least = _LAST_STEP * state.current_limit
        if abs(state.search_step) < least:
            state.search_step = least if state.search_step > 0.0 else -least
    state.search_power = power
    state.search_offset += state.search_step
    if state.search_offset > 0.0:
        # No current that strengthens the field is tried.
        state.search_offset = 0.0
        state.search_step = -0.5 * abs(state.search_step)


@inlined
def searched_offset(state: Any, torque: float, speed: float, power: float) -> float:
    """Return what is added to the current along the magnet's axis, in one period of the search for least power.

    Parameters
    ----------
    state : record of FOC_STATE
        Updated.
    torque : float
        Wanted (N m).
    speed : float
        Of the shaft (rad/s).
    power : float
        Given by the link in the period just ended (W).

    Returns
    -------
    float
        At most 0 (A); 0 until torque and speed are steady.

    Notes
    -----
    After Colby and Novotny, "An efficiency-optimizing permanent-magnet synchronous motor drive", IEEE Transactions on
    Industry Applications 24(3), 1988: in steady operation the output is constant, so least input is least loss.
    """
    is_other = abs(torque - state.search_torque) > _OTHER_TORQUE * state.greatest_torque
    if is_other or abs(speed - state.search_speed) > _OTHER_SPEED * abs(state.search_speed):
        forget_search(state, torque, speed)
        return 0.0
    state.search_count += 1
    if state.search_count > state.search_settling:
        state.search_sum += power
    if state.search_count >= state.search_settling + state.search_looking:
        _move(state, state.search_sum / state.search_looking)
        state.search_count = 0
        state.search_sum = 0.0
    return float(state.search_offset)
