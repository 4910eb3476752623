"""The search of the designs: each chooses the next angle its own way, all try it alike."""

from __future__ import annotations

from math import inf
from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.another_load import (
    LOAD_CHANGED,
    differs,
    is_lighter_load,
)
from drivegate_models.controllers.current.current_share import draws_less_than
from drivegate_models.controllers.current.designs.confirmation import (
    OFF_EDGE,
    UNCONFIRMED,
    begin_confirmation,
    continue_confirmation,
    is_worth_confirming,
    lowest_rest,
)
from drivegate_models.controllers.current.designs.golden_section import (
    begin_golden_section,
    continue_golden_section,
)
from drivegate_models.controllers.current.designs.probe import aim, approach, is_reached, is_read
from drivegate_models.controllers.current.designs.quadratic_interpolation import (
    begin_quadratic_interpolation,
    continue_quadratic_interpolation,
)
from drivegate_models.controllers.current.designs.rest import begin_watch, keep_off_edge, stands_still
from drivegate_models.controllers.current.designs.state import (
    ANGLE_TABLE,
    GOLDEN_SECTION,
    QUADRATIC_INTERPOLATION,
    SWEEP,
)
from drivegate_models.controllers.current.designs.sweep import begin_sweep, continue_sweep
from drivegate_models.controllers.current.designs.table import MOST_LOOKUPS, look_up
from drivegate_models.controllers.current.forbidden_angle import MARGIN, forget_other_load
from drivegate_models.controllers.current.protection import rearm
from drivegate_models.controllers.current.state import HOLDING
from drivegate_models.controllers.current.unrest import is_uneasy
from drivegate_models.controllers.current.watch import (
    BEGINNING,
    CONTINUING,
    WAITING,
    begin_holding,
    is_unloaded,
    watch_search,
)

LONGEST_SEARCH: Final = 40
"""Decisions after which a search is given up for the table."""
MOST_DECISIONS: Final = 44
"""Decisions after which the table is left with the cheapest angle so far."""
LATEST_DECISION: Final = 50
"""Decisions after which the confirmation ends, too."""

# Steps of two degrees explain more than one of a degree; upward they are rarer.
_FALL = 0.25
_RISE = 0.135
_LATEST_TO_CONFIRM = 38
_LOAD_CHANGED = 0.015
# At lighter load the current sum says little to search by, whatever the search: the table knows more.
_LEAST_TO_SEARCH = 0.2
# Of the greatest current sum.
_SMALLEST_CHANGE = 0.4 / 104.0


@inlined
def first_probe(state: Any) -> float:
    """Let the design choose its first angle, or the table where there is too little load to search.

    Returns
    -------
    float
        Offset from the initial angle (rad electrical).
    """
    if state.tabled == 1:
        return look_up(state, state.home_power)
    if state.design == GOLDEN_SECTION:
        return begin_golden_section(state)
    if state.design == QUADRATIC_INTERPOLATION:
        return begin_quadratic_interpolation(state)
    return begin_sweep(state)


@inlined
def next_probe(state: Any, power: float) -> float:
    """Let the design choose its next angle, and confirm the one it has found.

    Parameters
    ----------
    power : float
        What the last probe cost (A); infinite where the torque was lost.

    Returns
    -------
    float
        Offset from the initial angle (rad electrical).
    """
    if state.confirming != UNCONFIRMED:
        return continue_confirmation(state, power)
    if state.tabled == 1:
        # A table is looked up, not searched: there is nothing to confirm.
        return look_up(state, power)
    if state.design == GOLDEN_SECTION:
        probe = continue_golden_section(state, power)
    elif state.design == QUADRATIC_INTERPOLATION:
        probe = continue_quadratic_interpolation(state, power)
    else:
        probe = continue_sweep(state, power)
    # What took long is not worth the time: the search must come to rest.
    confirm = state.finished == 1 and state.decisions < _LATEST_TO_CONFIRM and is_worth_confirming(state)
    return begin_confirmation(state) if confirm else probe


@inlined
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
    light = draws_less_than(state.controller, _LEAST_TO_SEARCH)
    state.tabled = 1 if state.design == ANGLE_TABLE or light else 0
    state.finished = 0
    state.confirming = UNCONFIRMED
    state.stage = 0
    state.probes = 0
    state.decisions = 0
    state.finest = inf
    return first_probe(state)


@inlined
def note_cheapest(state: Any) -> None:
    """Keep the present angle where it is the cheapest so far."""
    power = state.controller.last_power
    if state.confirming != UNCONFIRMED:
        return
    # Where the torque is about to be lost, a speed that falls makes the current cheaper than it is.
    if power < state.best_power and not is_uneasy(state.controller):
        state.best_power = power
        state.best_offset = state.controller.offset


@inlined
def settle_for(state: Any, offset: float) -> None:
    """Aim at an angle, or at what the design says instead where it is known to lose the torque.

    Parameters
    ----------
    offset : float
        What the design requests (rad electrical).
    """
    requested = offset
    # What is known to lose the torque need not be tried: to the design it is infinitely dear.
    while state.finished == 0 and requested < state.controller.forbidden + MARGIN:
        requested = next_probe(state, inf)
    if state.finished == 1:
        requested = max(state.best_offset, lowest_rest(state.controller))
        begin_watch(state)
    aim(state, requested)


@inlined
def is_late(state: Any) -> bool:
    """Return whether the search, or its confirmation, has taken too long.

    Returns
    -------
    bool
        About the decisions made since it began.
    """
    late: bool = state.decisions >= (MOST_DECISIONS if state.confirming == UNCONFIRMED else LATEST_DECISION)
    return late


@inlined
def should_resort_to_table(state: Any) -> bool:
    """Return whether a search cannot end in time, or has too little current to search by.

    Returns
    -------
    bool
        False once it was given up.
    """
    late = state.confirming == UNCONFIRMED and state.decisions >= LONGEST_SEARCH
    return state.tabled == 0 and (late or draws_less_than(state.controller, _LEAST_TO_SEARCH))


@inlined
def is_misled(state: Any) -> bool:
    """Return whether a load that has changed leaves the search where it no longer belongs, as it does a fine sweep.

    Parameters
    ----------
    state : record of DESIGN_STATE
        The state, under another load than the search began with.

    Returns
    -------
    bool
        False once it was given up for the table.
    """
    fine = state.design == SWEEP and state.stage > 0
    misled: bool = fine and state.tabled == 0
    return misled


@inlined
def resort_to_table(state: Any) -> float:
    """Take the angle from the table from now on.

    Returns
    -------
    float
        Offset to probe (rad electrical).
    """
    state.tabled = 1
    state.confirming = UNCONFIRMED
    state.probes = 0
    return look_up(state, state.controller.last_power)


@inlined
def go_on(state: Any) -> float:
    """Go on from the present angle, since the load has changed.

    Returns
    -------
    float
        Offset to probe (rad electrical).
    """
    if state.design == ANGLE_TABLE:
        state.finished = 0
        return resort_to_table(state)
    # The optimum has moved with the load, but not so far that all has to be searched again.
    state.best_offset = state.controller.offset
    return begin_confirmation(state)


@inlined
def conclude(state: Any) -> None:
    """Rest at the angle found; go on from it where the load was another one when it was found."""
    controller = state.controller
    power = controller.last_power
    there = abs(controller.offset - state.best_offset) < OFF_EDGE
    changed = there and differs(controller, power, state.best_power, _LOAD_CHANGED, _SMALLEST_CHANGE)
    if changed and state.decisions < MOST_DECISIONS:
        settle_for(state, go_on(state))
    elif stands_still(state):
        begin_holding(controller, power)


@inlined
def accept_way_back(state: Any) -> None:
    """Settle no lower than where the way back led: the angle found there lost the torque. A table looks up again."""
    controller = state.controller
    if controller.offset <= state.best_offset:
        return
    state.best_offset = controller.offset
    state.best_power = controller.last_power
    # The way back may have been too long for the load that has grown; a table tells by how much, or small strides do.
    if state.design == ANGLE_TABLE and state.probes < MOST_LOOKUPS:
        state.finished = 0
        state.decisions = 0
        state.target = look_up(state, controller.last_power)
    elif state.tabled == 0 and controller.offset > lowest_rest(controller):
        state.decisions = 0
        state.target = begin_confirmation(state)


@inlined
def wait(state: Any) -> None:
    """Let a decision interval pass that tells the search nothing."""
    if state.controller.mode == HOLDING:
        keep_off_edge(state)
    elif is_unloaded(state.controller):
        # Nothing can be found meanwhile: the time that a search may take begins with the load.
        state.decisions = 0


@inlined
def go_on_way(state: Any, begins: bool, change: float) -> None:
    """Take the next step on the way to a probe, and keep what the last one has told.

    Parameters
    ----------
    begins : bool
        Whether the current sum has settled since the torque was lost.
    change : float
        Change of the mean current sum since the last decision (A).
    """
    if not begins:
        state.falls = state.falls if change < 0.0 else 0
    elif state.finished == 1:
        accept_way_back(state)
    else:
        note_cheapest(state)
    settle_for(state, state.target)


@inlined
def decide_design(state: Any) -> None:
    """Make one decision of a design.

    Parameters
    ----------
    state : record of DESIGN_STATE
        Updated; its decision interval is complete.
    """
    controller = state.controller
    state.decisions += 1
    # A table takes no steps at the end of which the current sum still rises.
    rise = LOAD_CHANGED if state.tabled == 1 else _RISE
    had_edge = controller.forbidden > -inf
    work, change = watch_search(controller, _FALL, rise, inf)
    if work == WAITING:
        wait(state)
        return
    if work == BEGINNING and is_lighter_load(controller, controller.last_power):
        rearm(controller)
        return
    forget_other_load(controller, controller.last_power)
    another_load = had_edge and controller.forbidden == -inf
    if another_load:
        # The time that a search may take begins with its load.
        state.decisions = 0
    misled = another_load and is_misled(state)
    if controller.good_power == inf:
        # Without a good angle: command, supply or load has changed.
        settle_for(state, begin_search(state))
    elif state.finished == 0 and (misled or should_resort_to_table(state)):
        settle_for(state, resort_to_table(state))
    elif state.finished == 0 and is_late(state):
        note_cheapest(state)
        state.finished = 1
        settle_for(state, state.best_offset)
    elif not is_reached(state):
        go_on_way(state, work == BEGINNING, change)
    elif work == CONTINUING and not is_read(state, change):
        return
    elif state.finished == 1:
        conclude(state)
        if is_reached(state):
            return
    else:
        note_cheapest(state)
        settle_for(state, next_probe(state, controller.last_power))
    approach(state)
