"""Field-oriented control of speed or torque: reference currents with field weakening, and duty ratios."""

from __future__ import annotations

from functools import cache
from math import nan
from typing import Any, Final

import numba
from numba.np.numpy_support import carray

from drivegate_models.compilation.calling import step_signature
from drivegate_models.compilation.kernels import KEEPS_CACHE, inlined
from drivegate_models.contract.duty.records import DUTY_COMMAND, DUTY_SENSE
from drivegate_models.controllers.duty.current_reference import (
    currents_for_torque,
    greatest_torque,
    least_current_direct,
    limited_by_voltage,
    torque_per_quadrature,
)
from drivegate_models.controllers.duty.current_regulator import (
    regulate_currents,
    reset_regulator,
    rotor_currents,
    voltage_limit,
)
from drivegate_models.controllers.duty.derating import derate, reset_derating
from drivegate_models.controllers.duty.flux_prediction import regulate_flux, reset_prediction
from drivegate_models.controllers.duty.hall_observer import reset_observer
from drivegate_models.controllers.duty.link_limits import limited_by_link, reset_link_limits
from drivegate_models.controllers.duty.loss_search import reset_search, restart_search, searched_offset
from drivegate_models.controllers.duty.missing_phase import watch_approach
from drivegate_models.controllers.duty.plausibility import (
    detect_fault,
    hold_safe_state,
    reset_plausibility,
    watch_flux,
)
from drivegate_models.controllers.duty.position import locate_shaft, regulated_speed, reset_position
from drivegate_models.controllers.duty.reference_voltage import (
    reset_voltage_share,
    share_voltage,
    with_reserve,
)
from drivegate_models.controllers.duty.speed_regulator import (
    LIMITED,
    ramped,
    requested_torque,
    reset_speed_regulator,
    unwind_speed,
)
from drivegate_models.controllers.duty.state import (
    BY_PREDICTION,
    FOC_STATE,
    MODELLED_LOSS,
    OF_TORQUE,
    SEARCHED_LOSS,
    UNWEAKENED,
)
from drivegate_models.controllers.duty.torque_regulation import regulate_torque, reset_torque_regulation

_NEWTON_STEPS: Final = 16
_CONVERGED: Final = 1e-9


@inlined
def reset_state(state: Any, nameplate: Any) -> None:
    """Write the constants of a controller and reset everything else, except for its aim and its regulation."""
    period = nameplate.control_period
    state.control_period = period
    reset_regulator(state, nameplate)
    reset_prediction(state)
    reset_torque_regulation(state)
    state.core_loss_conductance = nameplate.core_loss_conductance
    state.deepest = -nameplate.current_limit
    state.greatest_torque = greatest_torque(state)
    reset_derating(state, nameplate)
    speed_bandwidth, filter_rate = reset_speed_regulator(state, nameplate)
    state.added_flux = 0.0
    reset_link_limits(state, nameplate)
    reset_voltage_share(state)
    reset_search(state, nameplate)
    reset_position(state, nameplate, filter_rate)
    reset_observer(state, speed_bandwidth, nameplate.inertia)
    reset_plausibility(state, nameplate)


@inlined
def _currents_for(
    state: Any, torque: float, electrical: float, voltage: float, power: float
) -> tuple[float, float]:
    """Return the d-axis and q-axis currents (A) for a torque (N m), or for as much of it as the limits allow."""
    requested = min(abs(torque), state.greatest_torque)
    voltage, resistance = with_reserve(state, torque, requested, electrical, voltage)
    direct = least_current_direct(state, requested)
    if state.aim == MODELLED_LOSS:
        direct = _least_loss_direct(state, requested, electrical, direct)
    if state.aim != UNWEAKENED:
        direct, requested = limited_by_voltage(state, requested, electrical, voltage, resistance, direct)
    if state.aim == SEARCHED_LOSS:
        direct = _searched_direct(state, torque, requested, electrical, power, direct)
    return currents_for_torque(state, direct, requested, torque < 0.0)


@inlined
def _searched_direct(
    state: Any, torque: float, possible: float, electrical: float, power: float, direct: float
) -> float:
    """Return the d-axis current with the offset of the search for minimum power (A).

    There is no search if the limits do not allow the requested torque: less power is less torque.
    """
    speed = electrical / state.pole_pairs
    if possible < LIMITED * min(abs(torque), state.greatest_torque):
        restart_search(state, torque, speed)
        return direct
    searched: float = direct + searched_offset(state, torque, speed, power)
    found, quadrature = currents_for_torque(state, searched, possible, False)
    if torque_per_quadrature(state, found) * quadrature < LIMITED * possible:
        restart_search(state, torque, speed)
        return direct
    return searched


@inlined
def step_state(state: Any, sense: Any, command: Any) -> None:
    """Compute the command of one control period."""
    timed = sense.speed
    sense = locate_shaft(state, sense)
    speed = regulated_speed(state, sense, timed)
    command.angle = sense.angle
    command.speed = sense.speed
    direct, quadrature = rotor_currents(state, sense)
    watch_flux(state, sense, direct, quadrature)
    if detect_fault(state, sense):
        hold_safe_state(state, command)
        return
    regulate(state, sense, command, speed, direct, quadrature)


@inlined
def regulate(state: Any, sense: Any, command: Any, speed: float, direct: float, quadrature: float) -> None:
    """Write the duty ratios for the reference, by the speed (rad/s) and the d and q currents (A)."""
    electrical = state.pole_pairs * sense.speed
    derate(state, sense, direct, quadrature)
    limit = voltage_limit(state, sense)
    requested = requested_torque(state, sense.reference, speed)
    direct_reference, quadrature_reference = _currents_for(
        state,
        ramped(state, requested),
        electrical,
        state.voltage_share * limit,
        sense.supply_voltage * sense.supply_current,
    )
    direct_reference, quadrature_reference = limited_by_link(
        state, electrical, sense.supply_voltage, direct_reference, quadrature_reference
    )
    possible = torque_per_quadrature(state, direct_reference) * quadrature_reference
    unwind_speed(state, sense.reference, speed, requested, possible)
    watch_approach(state, direct, quadrature, direct_reference, quadrature_reference)

    if state.regulation == BY_PREDICTION:
        used = regulate_flux(
            state, sense, command, direct, quadrature, direct_reference, quadrature_reference
        )
    elif state.regulation == OF_TORQUE:
        used = regulate_torque(
            state, sense, command, direct, quadrature, direct_reference, quadrature_reference
        )
    else:
        used = regulate_currents(
            state, sense, command, direct, quadrature, direct_reference, quadrature_reference
        )
    share_voltage(state, used / max(limit, 1e-9))
    command.torque = torque_per_quadrature(state, direct) * quadrature
    state.seen_torque = command.torque
    state.quadrature_before = state.quadrature_seen
    state.direct_seen, state.quadrature_seen = direct, quadrature
    command.input_power = nan


@cache
def step_function() -> Any:
    """Return the controller's step, compiled.

    Its `address` is that of a C function. The caller must retain the object.
    """
    signature = step_signature(FOC_STATE, DUTY_SENSE, DUTY_COMMAND)

    def drivegate_duty_step(state: Any, sense: Any, command: Any) -> None:
        step_state(carray(state, 1)[0], carray(sense, 1)[0], carray(command, 1)[0])

    return numba.cfunc(signature, cache=KEEPS_CACHE)(drivegate_duty_step)


@cache
def reset_function() -> Any:
    """Return the compiled function that resets the controller.

    Its arguments are the state, shape (1,) of FOC_STATE, and the nameplate, shape (1,) of DUTY_NAMEPLATE.
    """

    def reset(state: Any, nameplate: Any) -> None:
        reset_state(state[0], nameplate[0])

    return numba.njit(cache=KEEPS_CACHE)(reset)


@inlined
def _least_loss_direct(state: Any, torque: float, electrical: float, direct: float) -> float:
    """Return the d-axis current (A) that provides a torque with minimum loss, limited to field weakening.

    `torque` is at least 0 (N m), `electrical` the electrical speed (rad/s) and `direct` the initial value (A, at
    most 0).

    After Morimoto, Tong, Takeda and Hirasa, "Loss minimization control of permanent magnet synchronous motor
    drives", IEEE Transactions on Industrial Electronics 41(5), 1994. With the q-axis current that produces the
    torque, ``R (i_d**2 + i_q**2) + G w**2 (psi_d**2 + psi_q**2)`` is convex in ``i_d``, so its slope is zero at the
    minimum.
    """
    saliency = state.direct_inductance - state.quadrature_inductance
    core = state.core_loss_conductance * electrical * electrical
    across = state.resistance + core * state.quadrature_inductance * state.quadrature_inductance
    along = state.resistance + core * state.direct_inductance * state.direct_inductance
    magnet = core * state.direct_inductance * state.magnet_flux
    for _ in range(_NEWTON_STEPS):
        per_ampere = torque_per_quadrature(state, direct)
        quadrature = torque / per_ampere
        change = -1.5 * state.pole_pairs * saliency * quadrature / per_ampere
        slope = along * direct + magnet + across * quadrature * change
        step = slope / (along + 3.0 * across * change * change)
        direct = min(max(direct - step, state.deepest), 0.0)
        if abs(step) <= _CONVERGED * state.current_limit:
            break
    return float(direct)
