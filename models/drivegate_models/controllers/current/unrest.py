"""What tells unrest from the errors of sensors and regulator: of the speed, and of the current sum."""

from __future__ import annotations

from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.state import SEARCHING

EXACT: Final = 1e-9
"""Greatest error of a speed that an encoder shows as exact by chance (rad/s): by rounding alone."""
JOLT: Final = 0.5
"""Share of k1 beyond which a search by steps of a degree takes a loss of speed for another load."""

# Of k1, and over the calmest error: the steps of an encoder alone are no sign of the edge.
_UNEASY = 0.1
_CALM = 1.5
# Of the current that the regulator adds, in as many phases as conduct.
_ANSWER = 0.5


@inlined
def unrest(state: Any, share: float, calm: float) -> float:
    """Return the speed error that is more than a share of k1 and the sensors' own part of it.

    Parameters
    ----------
    share : float
        Share of k1.
    calm : float
        Greatest error of a calm decision interval (rad/s).

    Returns
    -------
    float
        Speed error (rad/s).
    """
    error: float = share * state.speed_tolerance + _CALM * calm
    return error


@inlined
def is_uneasy(state: Any) -> bool:
    """Return whether the speed varied by more than sensors and regulator explain.

    Parameters
    ----------
    state : record of CONTROLLER_STATE
        The state; the calmest decision interval since the last change bounds what they explain.

    Returns
    -------
    bool
        About the decision interval just ended.
    """
    uneasy: bool = state.worst_error > unrest(state, _UNEASY, state.calm_error)
    return uneasy


@inlined
def is_sagging(state: Any) -> bool:
    """Return whether the speed varied so and is below its reference.

    Above it no torque is lost, however far the regulator is wound up: it unwinds.

    Returns
    -------
    bool
        About the decision interval just ended.
    """
    sagging: bool = is_uneasy(state) and state.error >= 0.0
    return sagging


@inlined
def is_jolted(state: Any, jolt: float) -> bool:
    """Return whether the speed is off by more than a step of the search makes of it.

    A step that costs speed is given back at once; any other jolt is the load's.

    Parameters
    ----------
    jolt : float
        Speed that one step of this search costs at most, as a share of k1.

    Returns
    -------
    bool
        False unless the search moves.
    """
    jolted: bool = state.worst_error > unrest(state, jolt, state.calm_error)
    return jolted and state.mode == SEARCHING


@inlined
def answer_of_regulator(state: Any, error: float) -> float:
    """Return what the regulator's answer to a speed error makes of the power.

    Parameters
    ----------
    error : float
        Speed error (rad/s).

    Returns
    -------
    float
        Current sum (A).
    """
    answer: float = _ANSWER * state.conducting_phases * state.proportional * error
    return answer


@inlined
def noise_of_regulator(state: Any) -> float:
    """Return what the regulator's answer to the speed sensor's errors makes of the power.

    Returns
    -------
    float
        Current sum (A).
    """
    # A greater error is no noise but a speed about to be lost.
    return answer_of_regulator(state, min(state.calm_error, _UNEASY * state.speed_tolerance))


@inlined
def noise_of_power(state: Any) -> float:
    """Return what the converter, and the regulator's answer to the speed sensor's errors, make of the power.

    Returns
    -------
    float
        Current sum (A).
    """
    noise: float = state.least_change + noise_of_regulator(state)
    return noise


@inlined
def is_answering(state: Any, power: float) -> bool:
    """Return whether the regulator's answer to the speed error moves the current sum by more than a search resolves.

    Parameters
    ----------
    power : float
        Mean current sum of the decision interval (A).

    Returns
    -------
    bool
        About the decision interval just ended.
    """
    resolved = state.power_tolerance * power + _CALM * noise_of_power(state)
    answering: bool = answer_of_regulator(state, state.worst_error) > resolved
    return answering
