"""How the designs move the advance angle, as an offset from the initial one, and what they average meanwhile."""

from __future__ import annotations

from math import inf, radians
from typing import Any, Final

from drivegate_models.compilation import (
    unfused,
)
from drivegate_models.design_state import LOWEST_ANGLE, MARGIN, MOVING, RESTING, SETTLING
from drivegate_models.regulation_guard import forget_alarms

WAIT: Final = 0
"""The search has nothing to do."""
BEGIN: Final = 1
"""The starting angle's current sum is known; the search begins."""
ABSORB: Final = 2
"""A probe has ended; its current sum is `old_power`, infinite where the torque was lost."""

INTERVAL: Final = 0.1
"""Length of the means of the current sum (s)."""

DOWNWARD: Final = radians(60.0)
"""Rate at which the angle goes down to a probe (rad electrical/s)."""

LOAD_CHANGED: Final = 0.03
"""Change of the current sum that means another load (1)."""
SMALLEST_CHANGE: Final = 0.05
"""Change of the current sum that means nothing (A)."""
MOST_RESTARTS: Final = 2
"""Number of times that an unexpected current sum at rest is looked into."""
CREEP_LEAST: Final = 0.3
"""Further growth of it that means nothing (A)."""
CREEP: Final = 1.1
"""Growth of the regulator's integral that means that it winds up in vain (1)."""
RETREAT: Final = radians(0.6)
"""Distance from an angle at which rest was disturbed (rad electrical)."""

_UPWARD = radians(300.0)
_HURRY = 5.0


@unfused
def begin_interval(state: Any) -> None:
    """Start a new mean of the current sum.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    """
    state.count = 0
    state.power_sum = 0.0
    state.first_half = 0.0
    state.worst_error = 0.0
    state.integral_sum = 0.0
    state.saturated = 0


@unfused
def enter(state: Any, mode: int) -> None:
    """Change the mode.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    mode : int
        The new mode.
    """
    state.mode = mode
    state.elapsed = 0
    state.repeats = 0
    state.intervals = 0
    begin_interval(state)


@unfused
def restart(state: Any) -> None:
    """Return to the starting angle and forget what was found: command, supply or load has changed.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    """
    state.target = state.home
    state.rate = DOWNWARD
    state.forbidden = -inf
    state.proven = state.home
    state.restarts = 0
    state.disturbances = 0
    state.doubtful = 0
    state.age = 0
    state.old_power = inf
    enter(state, SETTLING)


@unfused
def begin_anew(state: Any) -> None:
    """Search again, since what was found does not fit together; as often as the load's next change allows.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    """
    restarts = state.restarts + 1
    restart(state)
    state.restarts = restarts


@unfused
def go_to(state: Any, target: float, rate: float) -> None:
    """Send the angle to the next probe.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    target : float
        Offset from the initial angle (rad electrical).
    rate : float
        Rate of a downward movement (rad electrical/s).
    """
    state.target = min(max(target, LOWEST_ANGLE - state.line), state.home)
    state.rate = rate
    forget_alarms(state)
    enter(state, MOVING)


@unfused
def rest_at_best(state: Any) -> None:
    """End the search at the best angle that keeps off the forbidden one.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    """
    state.escapes = 0
    state.target = min(max(state.best_offset, state.forbidden + MARGIN), state.home)
    state.rate = DOWNWARD
    forget_alarms(state)
    enter(state, RESTING)


@unfused
def slew(state: Any) -> bool:
    """Move the offset toward its target by one control period.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.

    Returns
    -------
    bool
        Whether the target is reached.
    """
    # The way down to what was measured before is known.
    known = max(state.offset - max(state.target, state.proven), 0.0)
    lowest = state.offset - (state.rate + _HURRY * known) * state.control_period
    highest = state.offset + _UPWARD * state.control_period
    state.offset = min(max(state.target, lowest), highest)
    reached: bool = state.offset == state.target
    return reached
