"""A phase that carries no current, or current against its reference, while the field turns past it."""

from __future__ import annotations

from math import inf, pi
from typing import Any, Final

from drivegate_models.compilation.calling import double_at
from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.duty.current_regulator import largest_current
from drivegate_models.machine.rotor_frame import magnitude, of_phase
from drivegate_models.machine.sine import cosine_sine

# Current of a missing phase relative to the largest, because the diodes of an open leg carry some; minimum of its
# reference relative to the amplitude, and of the amplitude relative to the limit, or to twice the rated current where
# that is less; and rotation of the field meanwhile (rad electrical) with its maximum in a period. A healthy phase has
# that little current for 21 degrees.
_MISSING: Final = 0.2
_EXPECTED: Final = 0.5
_CARRYING: Final = 0.15
_PASSED: Final = pi / 5.0
_PASSED_IN_A_PERIOD: Final = _PASSED / 5.0
FREE: Final = 0.52
"""Voltage relative to that of the link up to which the regulators are free; the undistorted one is 0.577."""


@inlined
def reset_missing_phase(state: Any, nameplate: Any) -> None:
    """Write the least current that proves a phase, and miss none; the maximum torque must be set."""
    rated_share = nameplate.rated_power / nameplate.base_speed / state.greatest_torque
    state.carrying_current = _CARRYING * min(1.0, 2.0 * rated_share) * nameplate.current_limit
    state.direct_aim = 0.0
    state.quadrature_aim = 0.0
    # Current may flow before the first reference, through the diodes.
    state.least_error = inf
    for phase in range(3):
        state.passed[phase] = 0.0


@inlined
def passed_by(state: Any, sense: Any, turned: float) -> float:
    """Return the rotation of the field past the phases (rad electrical), without the step at a Hall edge."""
    most = _PASSED_IN_A_PERIOD
    if sense.hall >= 0:
        most = min(most, abs(float(state.pole_pairs * sense.speed * state.control_period)))
    return min(max(turned, -most), most)


@inlined
def is_phase_missing(state: Any, sense: Any, turned: float) -> bool:
    """Return True if the field has turned past a phase that carries far less current than its reference."""
    cosine, sine = cosine_sine(state.pole_pairs * sense.angle)
    along = cosine * state.direct_aim - sine * state.quadrature_aim
    across = sine * state.direct_aim + cosine * state.quadrature_aim
    amplitude = magnitude(along, across)
    carrying = state.carrying_current
    if amplitude <= carrying:
        # With little current, a phase without any proves nothing.
        return False
    currents = sense.phase_currents
    little = _MISSING * max(largest_current(sense), carrying)
    used = magnitude(state.along_voltage[0], state.across_voltage[0])
    is_free = sense.hall < 0 and used < FREE * sense.supply_voltage
    missing = False
    for phase in range(3):
        current, aim = double_at(currents, phase), of_phase(phase, along, across)
        # At low inductance, the diodes of an open leg carry much current against its reference. Within the voltage
        # limit nothing else lasts that long.
        along_aim = current if aim > 0.0 else -current
        lacks = abs(aim) > _EXPECTED * amplitude and (along_aim if is_free else abs(current)) < little
        without = lacks or abs(current) < little
        state.passed[phase] = state.passed[phase] + (turned if lacks else 0.0) if without else 0.0
        missing = missing or abs(state.passed[phase]) > _PASSED
    return missing


@inlined
def watch_approach(
    state: Any, direct: float, quadrature: float, direct_reference: float, quadrature_reference: float
) -> None:
    """Store the reference currents (A), and miss no phase while the measured currents (A) approach them.

    In a long step the current vector may stand while it shrinks, with hardly any current in one phase. The flux error
    then decreases in every period, because all regulators use the voltage nearest to the requested one. With an open
    phase it rises and falls as the field turns.
    """
    direct_flux, quadrature_flux = state.direct_inductance * direct, state.quadrature_inductance * quadrature
    before = magnitude(
        state.direct_inductance * state.direct_aim - direct_flux,
        state.quadrature_inductance * state.quadrature_aim - quadrature_flux,
    )
    if before < state.least_error:
        for phase in range(3):
            state.passed[phase] = 0.0
    after = magnitude(
        state.direct_inductance * direct_reference - direct_flux,
        state.quadrature_inductance * quadrature_reference - quadrature_flux,
    )
    least, farther = min(before, state.least_error), after - before
    if magnitude(direct, quadrature) < _MISSING * state.carrying_current:
        # A lost sample shows no currents. The reference may have moved away from the true ones by all of its change.
        least = state.least_error
        farther = magnitude(
            state.direct_inductance * (direct_reference - state.direct_aim),
            state.quadrature_inductance * (quadrature_reference - state.quadrature_aim),
        )
    state.direct_aim, state.quadrature_aim = direct_reference, quadrature_reference
    # A reference that moves changes the least error as much as the present one.
    state.least_error = max(least + farther, 0.0)
