"""The search of the designs: each chooses the next angle its own way, all try it alike."""

from __future__ import annotations

from math import inf, radians
from typing import Any, Final

from drivegate_models.angle_probe import aim, approach, is_reached, is_read
from drivegate_models.angle_sweep import begin_sweep, continue_sweep
from drivegate_models.angle_table import look_up
from drivegate_models.compilation import unfused
from drivegate_models.design_state import (
    ANGLE_TABLE,
    GOLDEN_SECTION,
    QUADRATIC_INTERPOLATION,
    SWEEP,
)
from drivegate_models.golden_section import begin_golden_section, continue_golden_section
from drivegate_models.quadratic_interpolation import (
    begin_quadratic_interpolation,
    continue_quadratic_interpolation,
)
from drivegate_models.search_protection import MARGIN, forget_other_load, rearm
from drivegate_models.search_watch import (
    BEGINNING,
    CONTINUING,
    WAITING,
    begin_holding,
    is_uneasy,
    watch_search,
)
from drivegate_models.slope_bisection import begin_slope_bisection, continue_slope_bisection

MOST_DECISIONS: Final = 46
"""Decisions after which a search ends with the cheapest angle so far."""

# Farther from the edge than a search goes: at rest, noise alone must not lead over it.
_OFF_EDGE = radians(0.8)
_LOAD_CHANGED = 0.03
_SMALLEST_CHANGE = 0.2


@unfused
def first_probe(state: Any) -> float:
    """Let the design choose its first angle.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.

    Returns
    -------
    float
        Offset from the initial angle (rad electrical).
    """
    if state.design == GOLDEN_SECTION:
        return begin_golden_section(state)
    if state.design == QUADRATIC_INTERPOLATION:
        return begin_quadratic_interpolation(state)
    if state.design == ANGLE_TABLE:
        return look_up(state, state.home_power)
    if state.design == SWEEP:
        return begin_sweep(state)
    return begin_slope_bisection(state)


@unfused
def next_probe(state: Any, power: float) -> float:
    """Let the design choose its next angle.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    power : float
        What the last probe cost (A); infinite where the torque was lost.

    Returns
    -------
    float
        Offset from the initial angle (rad electrical).
    """
    if state.design == GOLDEN_SECTION:
        return continue_golden_section(state, power)
    if state.design == QUADRATIC_INTERPOLATION:
        return continue_quadratic_interpolation(state, power)
    if state.design == ANGLE_TABLE:
        return look_up(state, power)
    if state.design == SWEEP:
        return continue_sweep(state, power)
    return continue_slope_bisection(state, power)


@unfused
def begin_search(state: Any) -> float:
    """Forget the last search, and begin at the present angle.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated; `speed` and `line` are those of the present.

    Returns
    -------
    float
        First offset to probe (rad electrical).
    """
    state.home = state.controller.offset
    state.home_power = state.controller.last_power
    state.best_offset = state.home
    state.best_power = state.home_power
    state.finished = 0
    state.stage = 0
    state.probes = 0
    state.decisions = 0
    return first_probe(state)


@unfused
def note_cheapest(state: Any) -> None:
    """Keep the present angle where it is the cheapest so far.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    """
    power = state.controller.last_power
    # Where the torque is about to be lost, a speed that falls makes the current cheaper than it is.
    if power < state.best_power and not is_uneasy(state.controller):
        state.best_power = power
        state.best_offset = state.controller.offset


@unfused
def settle_for(state: Any, offset: float) -> None:
    """Aim at an angle, or at what the design says instead where it is known to lose the torque.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    offset : float
        What the design wants (rad electrical).
    """
    wanted = offset
    while state.finished == 0 and wanted < state.controller.forbidden + MARGIN:
        wanted = next_probe(state, inf)
    if state.finished == 1:
        wanted = max(state.best_offset, state.controller.forbidden + _OFF_EDGE)
    aim(state, wanted)


@unfused
def conclude(state: Any) -> None:
    """Rest at the angle found; search anew where the load was another one when it was found.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated.
    """
    controller = state.controller
    power = controller.last_power
    there = abs(controller.offset - state.best_offset) < _OFF_EDGE
    if there and abs(power - state.best_power) > _LOAD_CHANGED * power + _SMALLEST_CHANGE:
        rearm(controller)
    else:
        begin_holding(controller, power)


@unfused
def decide_design(state: Any) -> None:
    """Make one decision of a design.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated; its decision interval is complete.
    """
    controller = state.controller
    state.decisions += 1
    work, change = watch_search(controller)
    if work == WAITING:
        return
    forget_other_load(controller, controller.last_power)
    if controller.good_power == inf:
        # Without a good angle: command, supply or load has changed.
        settle_for(state, begin_search(state))
    elif state.finished == 0 and state.decisions >= MOST_DECISIONS:
        state.finished = 1
        settle_for(state, state.best_offset)
    elif not is_reached(state):
        if state.finished == 1 and work == BEGINNING:
            # What was found has lost the torque: rest no lower than here.
            if controller.offset > state.best_offset:
                state.best_offset = controller.offset
                state.best_power = controller.last_power
        elif work == BEGINNING:
            note_cheapest(state)
        settle_for(state, state.target)
    elif work == CONTINUING and not is_read(state, change):
        return
    elif state.finished == 1:
        conclude(state)
        return
    else:
        note_cheapest(state)
        settle_for(state, next_probe(state, controller.last_power))
    approach(state)
