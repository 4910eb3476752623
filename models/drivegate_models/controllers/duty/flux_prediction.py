"""Currents of the rotor frame, led by prediction: every period brings the stator flux nearer to its reference."""

from __future__ import annotations

from math import isnan, nan, sqrt
from typing import Any

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.duty.current_regulator import (
    give_voltage,
    limited_voltage,
    voltage_limit,
)
from drivegate_models.machine.sine import cosine_sine

# Share of the way to the reference in a control period; the whole of it would be dead beat.
_SHARE = 0.3
# Share of what a prediction missed that is taken for a voltage the model does not have.
_TRUST = 0.1


@inlined
def reset_prediction(state: Any, nameplate: Any) -> None:
    """Write the constants of the prediction and forget everything else."""
    state.delay = 1 if nameplate.update_delay > 0 else 0
    state.direct_given = 0.0
    state.quadrature_given = 0.0
    state.direct_missed = 0.0
    state.quadrature_missed = 0.0
    state.direct_foreseen = nan
    state.quadrature_foreseen = nan


@inlined
def _period_later(
    state: Any, direct: float, quadrature: float, along: float, across: float, turned: tuple[float, float]
) -> tuple[float, float]:
    """Return a flux linkage a period later, in the rotor frame of then.

    Parameters
    ----------
    state : record of FOC_STATE
        The period.
    direct, quadrature : float
        Flux linkage in the rotor frame of now (V s).
    along, across : float
        What changes it, in that frame, which meanwhile stands still (V).
    turned : tuple of float
        Cosine and sine of the angle by which the rotor turns.

    Returns
    -------
    direct, quadrature : float
        (V s).
    """
    cosine, sine = turned
    direct += state.control_period * along
    quadrature += state.control_period * across
    return cosine * direct + sine * quadrature, cosine * quadrature - sine * direct


@inlined
def lead_flux(
    state: Any,
    sense: Any,
    command: Any,
    direct: float,
    quadrature: float,
    direct_reference: float,
    quadrature_reference: float,
) -> float:
    """Write the duty ratios that lead the currents to their references.

    Parameters
    ----------
    direct, quadrature : float
        Measured currents of the rotor frame (A).
    direct_reference, quadrature_reference : float
        (A).

    Returns
    -------
    float
        Peak voltage of a phase that was asked for (V).

    Notes
    -----
    After Lee, Choi, Seok and Lorenz, "Deadbeat-direct torque and flux control of interior permanent magnet synchronous
    machines with discrete time stator current and stator flux linkage observer", IEEE Transactions on Industry
    Applications 47(4), 2011. In the frame that stands still the flux linkage is the integral of ``v - R i``, whatever
    the speed: the voltage that acts already gives it at the end of its period, and what takes it from there to where
    it is to be one period later is the answer. What a prediction missed comes from resistance, magnet, dead time and
    drops that are not as the model has them; its mean is a voltage that the next predictions have.
    """
    electrical = state.pole_pairs * sense.speed
    turned = cosine_sine(electrical * state.control_period)
    cosine, sine = turned
    flux = state.direct_inductance * direct + state.magnet_flux
    across_flux = state.quadrature_inductance * quadrature
    is_first = isnan(state.direct_foreseen)
    if not is_first:
        state.direct_missed += _TRUST * (flux - state.direct_foreseen) / state.control_period
        state.quadrature_missed += _TRUST * (across_flux - state.quadrature_foreseen) / state.control_period
    along_drop = state.direct_missed - state.resistance * direct
    across_drop = state.quadrature_missed - state.resistance * quadrature
    # Until the first answer acts the legs are off, and the currents stay what they are.
    if state.delay == 1 and not is_first:
        along, across = state.direct_given + along_drop, state.quadrature_given + across_drop
        flux, across_flux = _period_later(state, flux, across_flux, along, across, turned)

    wanted = state.direct_inductance * direct_reference + state.magnet_flux
    across_wanted = state.quadrature_inductance * quadrature_reference
    left, across_left = wanted - flux, across_wanted - across_flux
    # The voltage that turns the wanted flux with the rotor and leads to it; that which turns what is left to it has no
    # part in the way there, and is added as far as the limit bears it.
    rate = 1.0 / state.control_period
    holding = state.resistance * direct_reference - state.direct_missed
    across_holding = state.resistance * quadrature_reference - state.quadrature_missed
    along = holding + rate * ((cosine - 1.0) * wanted - sine * across_wanted + _SHARE * left)
    across = across_holding + rate * (sine * wanted + (cosine - 1.0) * across_wanted + _SHARE * across_left)
    along_added = -rate * ((cosine - 1.0) * left - sine * across_left)
    across_added = -rate * (sine * left + (cosine - 1.0) * across_left)
    given, across_given = limited_voltage(along, across, along_added, across_added, voltage_limit(sense))

    if state.delay == 0:
        along_drop, across_drop = given + along_drop, across_given + across_drop
        flux, across_flux = _period_later(state, flux, across_flux, along_drop, across_drop, turned)
    state.direct_foreseen, state.quadrature_foreseen = flux, across_flux
    # In the frame of the period's start, which is that of the next sample where the answer comes later.
    state.direct_given, state.quadrature_given = given, across_given
    ahead = cosine_sine(state.pole_pairs * sense.angle + electrical * state.control_period * state.delay)
    give_voltage(
        state, sense, command, ahead, (given, across_given), (direct_reference, quadrature_reference)
    )
    along += along_added
    across += across_added
    return float(sqrt(along * along + across * across))
