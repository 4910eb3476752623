"""Faults of what happens at once: a change of the reference in a control period that has something else to handle."""

from __future__ import annotations

from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.duty.current_regulator import largest_current

# Control periods after a fall of the link in which a rise of the current counts as part of it.
_TOGETHER: Final = 50


@inlined
def taken_reference(state: Any, sense: Any) -> float:
    """Return the reference that is in use (rad/s or N m); call it before what updates the values seen.

    A change is noticed in its own period alone, and missed if the link steps or the currents are lost in it.
    """
    stepped = abs(sense.supply_voltage - state.link_before) > state.link_step > 0.0
    lost = largest_current(sense) == 0.0 and state.current_before > state.awaited_current > 0.0
    is_new = sense.reference != state.reference_seen and not stepped and not lost
    if state.is_following == 0 or is_new:
        state.reference_taken = sense.reference
    state.reference_seen = sense.reference
    return float(state.reference_taken)


@inlined
def is_short_circuit(state: Any, sense: Any) -> bool:
    """Return True if the current rises soon after a fall of the link."""
    largest = largest_current(sense)
    if state.link_before - sense.supply_voltage > state.link_fall > 0.0:
        state.fallen = _TOGETHER
        state.current_at_fall = largest
    state.link_before = sense.supply_voltage
    state.fallen = max(state.fallen - 1, 0)
    return bool(state.fallen > 0 and largest - state.current_at_fall > state.current_rise)
