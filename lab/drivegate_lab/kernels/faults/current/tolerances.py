"""Faults just beyond a tolerance, or just within it: oscillation, bias, late settling."""

from __future__ import annotations

from math import floor, pi
from typing import Any, Final

from drivegate_lab.kernels.faults.current import state as faults
from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.current.state import HOLDING

_ANGLE_PERIOD: Final = 2.0
_WELL_ABOVE: Final = 1.05
# Bandwidth of the regulator on the drive tuned on: its gain is this times inertia over torque per ampere (1/s).
_BANDWIDTH: Final = 80.0


@inlined
def _cycle(turns: float) -> float:
    """Return a wave of period 1 between -1 and 1, from parabolas that all processors round identically."""
    half = 1.0 - 2.0 * (turns - floor(turns))
    wave: float = 4.0 * half * (1.0 - abs(half))
    return wave


@inlined
def alter_speed(state: Any, fault: int) -> None:
    """Change the speed in the controller's copy of the Sense."""
    sense, controller = state.sense, state.controller
    if fault == faults.SPEED_BIASED:
        sense.speed -= state.size
    elif fault == faults.TORQUE_CYCLES and sense.speed > _WELL_ABOVE * controller.base_speed:
        # The acceleration of this speed needs that share of the torque; the gain contains the inertia.
        bandwidth = _BANDWIDTH * (controller.paced_period / controller.control_period)
        greatest = state.size * controller.integral * bandwidth / controller.proportional / (2.0 * pi)
        sense.speed += greatest * _cycle(sense.time)


@inlined
def cycle_angle(state: Any, fault: int, command: Any) -> None:
    """Move the angle away from the one found."""
    controller, sense = state.controller, state.sense
    added = 0.0
    if fault == faults.ANGLE_CYCLES:
        added = state.size * _cycle(sense.time / _ANGLE_PERIOD)
    elif fault == faults.RESTS_BESIDE:
        added = state.size if controller.mode == HOLDING else 0.0
    elif fault == faults.SETTLES_LATE:
        if sense.speed_reference != state.before.speed_reference:
            state.memory = 0.0
        state.memory += controller.control_period
        added = state.extent if state.memory < state.size else 0.0
    if controller.advancing == 1 and added != 0.0:
        command.advance_angle = min(max(command.advance_angle + added, 0.0), 0.5 * pi)
