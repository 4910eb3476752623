"""Minimum-loss currents from a model of copper and core loss."""

from __future__ import annotations

from typing import Any, Final

from drivegate_models.compilation.kernels import inlined
from drivegate_models.controllers.duty.current_reference import torque_per_quadrature

_NEWTON_STEPS: Final = 16
_CONVERGED: Final = 1e-9


@inlined
def least_loss_direct(state: Any, torque: float, electrical: float, direct: float) -> float:
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
