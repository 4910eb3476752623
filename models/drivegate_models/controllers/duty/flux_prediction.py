"""Predictive flux control: every period moves the stator flux toward its reference."""

from __future__ import annotations

from math import isnan, nan, sqrt
from typing import Any

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.duty.current_regulator import (
    limited_request,
    voltage_limit,
    write_voltage,
)
from drivegate_models.machine.sine import cosine_sine

# Share of the flux error that is removed in a control period; 1 is deadbeat control.
_SHARE = 0.3
# Share of the prediction error that is attributed to a voltage missing in the model.
_TRUST = 0.1


@inlined
def reset_prediction(state: Any) -> None:
    state.direct_given = 0.0
    state.quadrature_given = 0.0
    state.direct_missed = 0.0
    state.quadrature_missed = 0.0
    state.direct_foreseen = nan
    state.quadrature_foreseen = nan


@inlined
def _period_later(
    state: Any, direct: float, quadrature: float, turned: tuple[float, float]
) -> tuple[float, float]:
    """Return the d and q flux linkages after a period with the voltage given (V s), in the rotor frame at that time.

    `direct` and `quadrature` are the flux linkages at its start (V s). `turned` is the cosine and sine of the rotor's
    rotation. The voltage is in the rotor frame of the period's start, which is fixed meanwhile.
    """
    cosine, sine = turned
    direct += state.control_period * (state.direct_given + state.direct_missed)
    quadrature += state.control_period * (state.quadrature_given + state.quadrature_missed)
    return cosine * direct + sine * quadrature, cosine * quadrature - sine * direct


@inlined
def _currents_of(state: Any, direct: float, quadrature: float) -> tuple[float, float]:
    """Return the d and q currents of flux linkages (A)."""
    return (direct - state.magnet_flux) / state.direct_inductance, quadrature / state.quadrature_inductance


@inlined
def _mean_drop(
    state: Any, start: tuple[float, float], end: tuple[float, float], halfway: tuple[float, float]
) -> tuple[float, float]:
    """Return the mean voltage across the resistance in a period (V), in the rotor frame of its start.

    `start` and `end` are the d and q currents there (A), each in the rotor frame of its time; `halfway` is the cosine
    and sine of the rotor's rotation up to the middle.
    """
    cosine, sine = halfway
    direct = 0.5 * state.resistance * (start[0] + end[0])
    quadrature = 0.5 * state.resistance * (start[1] + end[1])
    return cosine * direct - sine * quadrature, cosine * quadrature + sine * direct


@inlined
def regulate_flux(
    state: Any,
    sense: Any,
    command: Any,
    direct: float,
    quadrature: float,
    direct_reference: float,
    quadrature_reference: float,
) -> float:
    """Write the duty ratios that move the measured currents (A) to their references (A).

    Return the requested peak phase voltage (V), before the limit.

    After Lee, Choi, Seok and Lorenz, "Deadbeat-direct torque and flux control of interior permanent magnet
    synchronous machines with discrete time stator current and stator flux linkage observer", IEEE Transactions on
    Industry Applications 47(4), 2011. In the stationary frame the flux linkage is the integral of ``v - R i`` at
    any speed. The voltage that already acts determines it at the end of its period. The command is the voltage that
    moves it from there to the desired value one period later. Prediction errors come from deviations of resistance,
    magnet, dead time and voltage drops; their mean is a voltage that later predictions include.
    """
    electrical = state.pole_pairs * sense.speed
    turned = cosine_sine(electrical * state.control_period)
    halfway = cosine_sine(0.5 * electrical * state.control_period)
    cosine, sine = turned
    flux = state.direct_inductance * direct + state.magnet_flux
    across_flux = state.quadrature_inductance * quadrature
    is_first = isnan(state.direct_foreseen)
    if not is_first:
        state.direct_missed += _TRUST * (flux - state.direct_foreseen) / state.control_period
        state.quadrature_missed += _TRUST * (across_flux - state.quadrature_foreseen) / state.control_period
    # Until the first command acts, the legs are off and the currents do not change.
    if state.delay == 1 and not is_first:
        flux, across_flux = _period_later(state, flux, across_flux, turned)

    desired = state.direct_inductance * direct_reference + state.magnet_flux
    across_desired = state.quadrature_inductance * quadrature_reference
    error, across_error = desired - flux, across_desired - across_flux
    now, across_now = _currents_of(state, flux, across_flux)
    drop, across_drop = _mean_drop(
        state,
        (now, across_now),
        (now + _SHARE * (direct_reference - now), across_now + _SHARE * (quadrature_reference - across_now)),
        halfway,
    )
    # The voltage that rotates the desired flux with the rotor, the one that moves the flux toward it, and the one that
    # rotates the rest of the flux error, so that it decouples without reducing it.
    rate = 1.0 / state.control_period
    steady, across_steady = drop - state.direct_missed, across_drop - state.quadrature_missed
    steady += rate * ((cosine - 1.0) * desired - sine * across_desired)
    across_steady += rate * (sine * desired + (cosine - 1.0) * across_desired)
    moving, across_moving = rate * _SHARE * error, rate * _SHARE * across_error
    left = (_SHARE - 1.0) * rate
    along_added = left * ((cosine - 1.0) * error - sine * across_error)
    across_added = left * (sine * error + (cosine - 1.0) * across_error)
    applied, across_applied = limited_request(
        (steady, across_steady),
        (moving, across_moving),
        (along_added, across_added),
        voltage_limit(state, sense),
    )
    along = steady + moving + along_added
    across = across_steady + across_moving + across_added

    # The same drop in prediction and command leaves no error at rest; within the limit it is that of other currents.
    state.direct_given, state.quadrature_given = applied - drop, across_applied - across_drop
    foreseen = _period_later(state, flux, across_flux, turned)
    if applied != along or across_applied != across:
        drop, across_drop = _mean_drop(
            state, (now, across_now), _currents_of(state, foreseen[0], foreseen[1]), halfway
        )
        state.direct_given, state.quadrature_given = applied - drop, across_applied - across_drop
        foreseen = _period_later(state, flux, across_flux, turned)
    if state.delay == 0:
        flux, across_flux = foreseen
    state.direct_foreseen, state.quadrature_foreseen = flux, across_flux
    ahead = cosine_sine(state.pole_pairs * sense.angle + electrical * state.control_period * state.delay)
    middle = (
        ahead[0] * halfway[0] - ahead[1] * halfway[1],
        ahead[1] * halfway[0] + ahead[0] * halfway[1],
    )
    voltage, current = (applied, across_applied), (direct_reference, quadrature_reference)
    write_voltage(state, sense, command, ahead, middle, voltage, current)
    return float(sqrt(along * along + across * across))
