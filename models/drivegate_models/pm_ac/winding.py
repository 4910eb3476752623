"""The temperature of the windings: one thermal node that the copper loss heats, and a sensor that lags behind it."""

from __future__ import annotations

from math import nan
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.pm_ac.decay import TERMS, decay_of

TRUE: Final = 0
"""Index of the temperature of the windings in `Winding.state`."""
SENSED: Final = 1
"""Index of the temperature that the sensor shows."""


class Winding(NamedTuple):
    """The thermal node of a drive, and its state.

    With the copper loss ``P``, the heat capacity ``C`` and the resistance ``R`` to the surroundings, ``C dT/dt = P -
    (T - T_a) / R``, and the sensor follows by ``dS/dt = (T - S) / lag``. Over a control period with its mean loss both
    are solved exactly.
    """

    is_heated: bool
    """False for a drive without thermal data, whose windings keep their resistance."""
    is_sensed: bool
    """True if the controller sees a temperature."""
    ambient: float
    """Temperature of the surroundings, at which the windings have their nominal resistance (deg C)."""
    rise: float
    """Thermal resistance: rise of the steady temperature over the loss (K/W)."""
    coefficient: float
    """Change of the resistance over its value at the ambient temperature, for a change of temperature (1/K)."""
    decay: float
    """Share of a deviation from the steady temperature that is left after a control period (1)."""
    lag_decay: float
    """Share of a deviation of the sensor from the steady temperature that is left after a control period (1)."""
    coupling: float
    """Share of the winding's deviation that is in the sensor's one after a control period (1)."""
    state: NDArray[np.float64]
    """Temperatures of the winding and of its sensor, shape (2,) (deg C)."""


def no_winding() -> Winding:
    """Return the node of a drive without thermal data."""
    return Winding(False, False, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, np.full(2, nan))


def copied_winding(winding: Winding) -> Winding:
    """Return a node with a state of its own, so that a run can be repeated."""
    return winding._replace(state=winding.state.copy())


def make_winding(
    *,
    heat_capacity: float,
    thermal_resistance: float,
    ambient: float,
    coefficient: float,
    control_period: float,
    initial: float,
    lag: float | None,
) -> Winding:
    """Return the node of a drive at a temperature that it has had for long.

    `heat_capacity`: of all windings together (J/K). `thermal_resistance`: to the surroundings (K/W). `ambient`,
    `initial`: temperatures (deg C). `coefficient`: of the resistance (1/K). `control_period`, `lag`: times (s), the lag
    of the sensor 0 or at least a control period, None without a sensor.
    """
    share = control_period / (heat_capacity * thermal_resistance)
    decay = decay_of(share)
    lag_decay, coupling = 0.0, decay
    if lag:
        sensed_share = control_period / lag
        lag_decay, coupling = decay_of(sensed_share), sensed_share * _decay_between(share, sensed_share)
    return Winding(
        True,
        lag is not None,
        float(ambient),
        float(thermal_resistance),
        float(coefficient),
        decay,
        lag_decay,
        coupling,
        np.full(2, float(initial)),
    )


def _decay_between(first: float, second: float) -> float:
    """Return ``(exp(-a) - exp(-b)) / (b - a)`` by its series, which also is right where both are equal."""
    total, power, sum_of_products, factor = 0.0, 1.0, 1.0, 1.0
    for order in range(TERMS):
        total += factor * sum_of_products
        power *= first
        sum_of_products = power + second * sum_of_products
        factor *= -1.0 / (order + 2)
    return total


@inlined
def resistance_factor(winding: Winding) -> float:
    """Return the resistance of the windings over its nominal value (1)."""
    if not winding.is_heated:
        return 1.0
    return float(1.0 + winding.coefficient * (winding.state[TRUE] - winding.ambient))


@inlined
def shown_temperature(winding: Winding) -> float:
    """Return what the sensor shows (deg C), NaN without one."""
    return winding.state[SENSED] if winding.is_sensed else nan


@inlined
def heat_winding(winding: Winding, loss: float) -> None:
    """Advance the node by a control period with a mean copper loss (W)."""
    if not winding.is_heated:
        return
    state = winding.state
    steady = winding.ambient + winding.rise * loss
    above = state[TRUE] - steady
    state[SENSED] = steady + (winding.lag_decay * (state[SENSED] - steady) + winding.coupling * above)
    state[TRUE] = steady + winding.decay * above
