"""The search of the designs: each chooses the next angle differently, and all try it in the same way."""

from __future__ import annotations

from math import inf, radians
from typing import Any, Final

from drivegate_lab.kernels.designs.confirmation import (
    OFF_EDGE,
    UNCONFIRMED,
    begin_confirmation,
    continue_confirmation,
    is_worth_confirming,
    lowest_rest,
)
from drivegate_lab.kernels.designs.golden_section import (
    begin_golden_section,
    continue_golden_section,
)
from drivegate_lab.kernels.designs.probe import aim, approach, is_reached, is_read
from drivegate_lab.kernels.designs.quadratic_interpolation import (
    begin_quadratic_interpolation,
    continue_quadratic_interpolation,
)
from drivegate_lab.kernels.designs.rest import begin_watch, is_rest_confirmed, step_off_edge
from drivegate_lab.kernels.designs.state import (
    ANGLE_TABLE,
    GOLDEN_SECTION,
    LOWEST_ANGLE,
    QUADRATIC_INTERPOLATION,
    SWEEP,
)
from drivegate_lab.kernels.designs.table import MOST_LOOKUPS, look_up
from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.another_load import (
    LOAD_CHANGED,
    differs,
    is_lighter_load,
)
from drivegate_models.controllers.current.current_share import is_current_below
from drivegate_models.controllers.current.forbidden_angle import MARGIN, forget_other_load
from drivegate_models.controllers.current.modes import hold_angle, rearm
from drivegate_models.controllers.current.state import HOLDING
from drivegate_models.controllers.current.unrest import is_speed_unsteady
from drivegate_models.controllers.current.watch import (
    BEGINNING,
    CONTINUING,
    WAITING,
    is_current_too_small,
    is_load_varying,
    watch_search,
)

_COARSE = radians(2.0)
_FINE = radians(0.5)
_COARSE_RISE = 1.05
# Under a heavy load, a share of the maximum current sum, little current is left to bring the torque back with.
_COARSE_RISE_HEAVY = 1.02
_HEAVY = 0.5
_FINE_RISE = 1.01
_AROUND = radians(1.25)
LONGEST_SEARCH: Final = 40
"""Decisions after which a search falls back to the table."""
MOST_DECISIONS: Final = 44
"""Decisions after which the table's search ends at the cheapest angle so far."""
LATEST_DECISION: Final = 50
"""Decisions after which the confirmation ends, too."""

# Steps of two degrees explain larger changes than one-degree steps; upward they are rarer.
_FALL = 0.25
_RISE = 0.135
_LATEST_TO_CONFIRM = 38
_LOAD_CHANGED = 0.015
# At lighter load the current sum is too uncertain for any search; the table is more accurate.
_LEAST_TO_SEARCH = 0.2
# Share of the maximum current sum.
_SMALLEST_CHANGE = 0.4 / 104.0


@inlined
def first_probe(state: Any) -> float:
    """Return the design's first offset (rad electrical), or the table's if the load is too light for a search."""
    if state.tabled == 1:
        return look_up(state, state.home_power)
    if state.design == GOLDEN_SECTION:
        return begin_golden_section(state)
    if state.design == QUADRATIC_INTERPOLATION:
        return begin_quadratic_interpolation(state)
    return _begin_sweep(state)


@inlined
def next_probe(state: Any, current_sum: float) -> float:
    """Return the design's next offset (rad electrical), and confirm the angle once the design has found it.

    `current_sum` is what the last probe cost (A), infinite if the torque was lost.
    """
    if state.confirming != UNCONFIRMED:
        return continue_confirmation(state, current_sum)
    if state.tabled == 1:
        # A table look-up is not a search: there is nothing to confirm.
        return look_up(state, current_sum)
    if state.design == GOLDEN_SECTION:
        probe = continue_golden_section(state, current_sum)
    elif state.design == QUADRATIC_INTERPOLATION:
        probe = continue_quadratic_interpolation(state, current_sum)
    else:
        probe = _continue_sweep(state, current_sum)
    # After a long search there is no time to confirm: it must come to rest.
    confirm = state.finished == 1 and state.decisions < _LATEST_TO_CONFIRM and is_worth_confirming(state)
    return begin_confirmation(state) if confirm else probe


@inlined
def begin_search(state: Any) -> float:
    """Start a new search at the present angle, and return the first offset to probe (rad electrical).

    `speed` and `line` must be up to date.
    """
    state.home = state.controller.offset
    state.home_power = state.controller.last_power
    state.best_offset = state.home
    state.best_power = state.home_power
    light = is_current_below(state.controller, _LEAST_TO_SEARCH)
    state.tabled = 1 if state.design == ANGLE_TABLE or light else 0
    state.finished = 0
    state.confirming = UNCONFIRMED
    state.stage = 0
    state.probes = 0
    state.decisions = 0
    state.finest = inf
    return first_probe(state)


@inlined
def record_cheapest(state: Any) -> None:
    """Store the present angle if it is the cheapest so far."""
    current_sum = state.controller.last_power
    if state.confirming != UNCONFIRMED:
        return
    # Just before the torque is lost, the falling speed makes the current sum too small.
    if current_sum < state.best_power and not is_speed_unsteady(state.controller):
        state.best_power = current_sum
        state.best_offset = state.controller.offset


@inlined
def set_target(state: Any, offset: float) -> None:
    """Aim at an offset (rad electrical), or at the design's next choice if it is known to lose the torque."""
    requested = offset
    # An angle known to lose the torque is not tried: to the design it costs infinite current.
    while state.finished == 0 and requested < state.controller.forbidden + MARGIN:
        requested = next_probe(state, inf)
    if state.finished == 1:
        requested = max(state.best_offset, lowest_rest(state.controller))
        begin_watch(state)
    aim(state, requested)


@inlined
def is_late(state: Any) -> bool:
    """Return True if the search, or its confirmation, has taken too many decisions."""
    late: bool = state.decisions >= (MOST_DECISIONS if state.confirming == UNCONFIRMED else LATEST_DECISION)
    return late


@inlined
def should_fall_back_to_table(state: Any) -> bool:
    """Return True if a search cannot end in time, or has too little current to search by.

    False once the search uses the table.
    """
    late = state.confirming == UNCONFIRMED and state.decisions >= LONGEST_SEARCH
    return state.tabled == 0 and (late or is_current_below(state.controller, _LEAST_TO_SEARCH))


@inlined
def is_misled(state: Any) -> bool:
    """Return True if another load invalidates the position of the search, as it does in a fine sweep.

    False once the search uses the table.
    """
    fine = state.design == SWEEP and state.stage > 0
    misled: bool = fine and state.tabled == 0
    return misled


@inlined
def fall_back_to_table(state: Any) -> float:
    """Use the table from now on, and return its offset to probe (rad electrical)."""
    state.tabled = 1
    state.confirming = UNCONFIRMED
    state.probes = 0
    return look_up(state, state.controller.last_power)


@inlined
def continue_from_present_angle(state: Any) -> float:
    """Continue from the present angle after a change of load, and return the next offset to probe (rad electrical)."""
    if state.design == ANGLE_TABLE:
        state.finished = 0
        return fall_back_to_table(state)
    # The optimum has moved with the load, but not so far that a new search is needed.
    state.best_offset = state.controller.offset
    return begin_confirmation(state)


@inlined
def conclude(state: Any) -> None:
    """Rest at the angle found, or continue from it if the load has changed since it was found."""
    controller = state.controller
    current_sum = controller.last_power
    there = abs(controller.offset - state.best_offset) < OFF_EDGE
    changed = there and differs(controller, current_sum, state.best_power, _LOAD_CHANGED, _SMALLEST_CHANGE)
    if changed and state.decisions < MOST_DECISIONS:
        set_target(state, continue_from_present_angle(state))
    elif is_rest_confirmed(state):
        hold_angle(controller, current_sum)


@inlined
def accept_reverted_angle(state: Any) -> None:
    """Settle no lower than the angle reached after a loss of torque; a table looks up again."""
    controller = state.controller
    if controller.offset <= state.best_offset:
        return
    state.best_offset = controller.offset
    state.best_power = controller.last_power
    # The angle may have been reverted too far for a load that has grown. The table, or small strides, correct this.
    if state.design == ANGLE_TABLE and state.probes < MOST_LOOKUPS:
        state.finished = 0
        state.decisions = 0
        state.target = look_up(state, controller.last_power)
    elif state.tabled == 0 and controller.offset > lowest_rest(controller):
        state.decisions = 0
        state.target = begin_confirmation(state)


@inlined
def process_waiting(state: Any) -> None:
    """Process a decision interval without information for the search."""
    if state.controller.mode == HOLDING:
        step_off_edge(state)
        return
    if is_load_varying(state.controller) or is_current_too_small(state.controller):
        # Nothing can be found meanwhile, so the limit of decisions starts with the load.
        state.decisions = 0


@inlined
def continue_approach(state: Any, begins: bool, change: float) -> None:
    """Take the next step toward a probe, and use what the last step has shown.

    `begins` is True if the current sum has settled since the torque was lost. `change` is the change of the mean
    current sum since the last decision (A).
    """
    if not begins:
        state.falls = state.falls if change < 0.0 else 0
    elif state.finished == 1:
        accept_reverted_angle(state)
    else:
        record_cheapest(state)
    set_target(state, state.target)


@inlined
def decide_design(state: Any) -> None:
    """Make one decision of a design, at the end of an interval."""
    controller = state.controller
    state.decisions += 1
    # After a step to the table's angle the current sum no longer rises.
    rise = LOAD_CHANGED if state.tabled == 1 else _RISE
    had_edge = controller.forbidden > -inf
    action, change = watch_search(controller, _FALL, rise, inf)
    if action == WAITING:
        process_waiting(state)
        return
    if action == BEGINNING and is_lighter_load(controller, controller.last_power):
        rearm(controller)
        return
    forget_other_load(controller, controller.last_power)
    another_load = had_edge and controller.forbidden == -inf
    if another_load:
        # The limit of decisions starts with the load.
        state.decisions = 0
    misled = another_load and is_misled(state)
    if controller.good_power == inf:
        # Without a good angle: command, supply or load has changed.
        set_target(state, begin_search(state))
    elif state.finished == 0 and (misled or should_fall_back_to_table(state)):
        set_target(state, fall_back_to_table(state))
    elif state.finished == 0 and is_late(state):
        record_cheapest(state)
        state.finished = 1
        set_target(state, state.best_offset)
    elif not is_reached(state):
        continue_approach(state, action == BEGINNING, change)
    elif action == CONTINUING and not is_read(state, change):
        return
    elif state.finished == 1:
        conclude(state)
        if is_reached(state):
            return
    else:
        record_cheapest(state)
        set_target(state, next_probe(state, controller.last_power))
    approach(state)


@inlined
def _begin_sweep(state: Any) -> float:
    """Sweep down from the starting angle, and return the first offset to probe (rad electrical).

    `left` is the cheapest offset, `right` the last one, and `low` the end of the sweep.
    """
    state.left = state.home
    state.left_power = state.home_power
    state.low = LOWEST_ANGLE - state.line
    state.right = state.home - _COARSE
    probe: float = state.right
    return probe


@inlined
def _continue_sweep(state: Any, current_sum: float) -> float:
    """Continue down until the current sum rises or the torque is lost, then sweep finely around the minimum.

    `stage` is 0 during the coarse sweep, 1 on the way back up and 2 during the fine sweep. `current_sum` is what
    the last probe cost (A), infinite if the torque was lost. Return the next offset to probe (rad electrical).
    """
    # At the top of the fine sweep, replace the value that the coarse sweep measured there.
    if state.stage == 1 or current_sum < state.left_power:
        state.left = state.right
        state.left_power = current_sum
    # Ignore a small rise: at light load the current sum has local minima.
    coarse = _COARSE_RISE if is_current_below(state.controller, _HEAVY) else _COARSE_RISE_HEAVY
    ended = current_sum > state.left_power * (coarse if state.stage == 0 else _FINE_RISE)
    step = _COARSE if state.stage == 0 else _FINE
    ended = ended or state.right - step < state.low
    if state.stage == 0 and ended and is_worth_confirming(state):
        state.stage = 1
        state.low = max(state.low, state.left - _AROUND)
        # Like the coarse sweep, the fine sweep descends from the side that provides the torque.
        state.right = min(state.left + _AROUND, state.home)
    elif ended:
        state.best_offset = state.left
        state.finished = 1
    else:
        state.stage = 2 if state.stage > 0 else 0
        state.right -= step
    probe: float = state.right
    return probe
