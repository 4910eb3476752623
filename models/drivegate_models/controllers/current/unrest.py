"""Thresholds that separate speed and current disturbances from errors of the sensors and the regulator."""

from __future__ import annotations

from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.state import SEARCHING

EXACT: Final = 1e-9
"""Maximum speed error, by rounding alone, of an encoder reading that is exact by chance (rad/s)."""
JOLT: Final = 0.5
"""Share of k1 beyond which a search with one-degree steps attributes a loss of speed to another load."""

# Share of k1, and multiple of the smallest error: quantization by an encoder alone does not indicate the edge.
_UNSTEADY = 0.1
_CALM = 1.5
# Share of what the largest speed error adds to the integral when it lasts for the whole interval.
_LASTING = 0.25
# Share of the largest speed error of an interval.
_RETURNED = 0.5
# Share of the current that the regulator adds in the conducting phases.
_RESPONSE = 0.5


@inlined
def disturbed_speed_error(state: Any, share: float, calm: float) -> float:
    """Return the speed error (rad/s) beyond `share` of k1 plus the sensors' own error.

    `calm` is the maximum speed error of the calmest decision interval (rad/s).
    """
    error: float = share * state.speed_tolerance + _CALM * calm
    return error


@inlined
def is_speed_unsteady(state: Any) -> bool:
    """Return True if the speed varied by more than sensors and regulator explain in the interval just ended.

    The calmest interval since the last change of load bounds what they explain.
    """
    unsteady: bool = state.worst_error > disturbed_speed_error(state, _UNSTEADY, state.calm_error)
    return unsteady


@inlined
def is_speed_returning(state: Any) -> bool:
    """Return True if most of the speed lost in the interval just ended was back at its end.

    Where less angle needs a higher current reference, the speed must fall a little until the regulator has found it.
    Lost torque does not return.
    """
    returning: bool = state.error <= _RETURNED * state.worst_error
    return returning


@inlined
def is_sagging(state: Any) -> bool:
    """Return True if the speed was unsteady, is below its reference and does not return.

    Above the reference no torque is lost, however far the regulator is wound up: it unwinds.
    """
    sagging: bool = is_speed_unsteady(state) and state.error >= 0.0 and not is_speed_returning(state)
    return sagging


@inlined
def is_sag_lasting(state: Any) -> bool:
    """Return True if the speed is sagging, and the regulator's integral has followed it.

    Errors of the speed sensor cancel out in the integral, unless it is at its limit.
    """
    followed = _LASTING * state.integral_step * state.decision_steps * state.worst_error
    lasting: bool = state.integral_growth >= followed or state.integral >= state.current_limit
    return lasting and is_sagging(state)


@inlined
def is_jolted(state: Any, jolt: float) -> bool:
    """Return True if the search is moving and the speed error exceeds the effect of one step.

    `jolt` is the maximum loss of speed by one step of this search, as a share of k1. A step that costs speed is
    reverted at once, so the load causes any larger error.
    """
    jolted: bool = state.worst_error > disturbed_speed_error(state, jolt, state.calm_error)
    return jolted and state.mode == SEARCHING


@inlined
def regulator_response(state: Any, error: float) -> float:
    """Return the change of the current sum (A) by the regulator's response to a speed error (rad/s)."""
    response: float = _RESPONSE * state.conducting_phases * state.proportional * error
    return response


@inlined
def regulator_noise(state: Any) -> float:
    """Return the change of the current sum (A) by the regulator's response to errors of the speed sensor."""
    # A larger error is not noise: the speed is about to be lost.
    return regulator_response(state, min(state.calm_error, _UNSTEADY * state.speed_tolerance))


@inlined
def current_sum_noise(state: Any) -> float:
    """Return the noise of the current sum (A) from the converter and from errors of the speed sensor."""
    noise: float = state.least_change + regulator_noise(state)
    return noise


@inlined
def is_regulator_responding(state: Any, current_sum: float) -> bool:
    """Return True if the regulator's response to the speed error exceeds the search's resolution.

    `current_sum` is the mean of the decision interval just ended (A).
    """
    resolution = state.power_tolerance * current_sum + _CALM * current_sum_noise(state)
    responding: bool = regulator_response(state, state.worst_error) > resolution
    return responding
