"""The best possible operation of a drive: the reference values for candidates.

All values are from the exact steady state, by exhaustive search at a speed and a mean torque. Torque means the
electromagnetic torque, without subtraction of the core loss's drag on the shaft.
"""

from __future__ import annotations

from math import isnan, nan
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drivegate_models.steady.advance_line import (
    AdvanceLine,
    demanded_torque,
    recommended_line,
)
from drivegate_models.steady.angle_search import (
    least_cost,
    search_reference,
    smallest_feasible,
    torque_demand,
)
from drivegate_models.steady.current_search import (
    CURRENT_TOLERANCE,
    OUT_OF_REACH,
    ROBUST,
    STATIC,
    ReferenceSearch,
    reference_for_torque,
)
from drivegate_models.steady.plant import AnyDrive, make_phases
from drivegate_models.steady.steady_state import KEPT_TIME, SteadyState, solve_steady_state
from drivegate_models.steady.torque_limit import (
    GreatestTorque,
    greatest_torque_at_limit,
    torques_at_limit,
)

__all__ = [
    "CURRENT_TOLERANCE",
    "OUT_OF_REACH",
    "ROBUST",
    "STATIC",
    "AdvanceLine",
    "CurrentSumCurve",
    "GreatestTorque",
    "Optimum",
    "TorquePoint",
    "current_sum_curve",
    "demanded_torque",
    "feasible_edge",
    "greatest_torque_at_limit",
    "least_current_sum",
    "least_input_power",
    "point_at_torque",
    "recommended_line",
    "reference_for_torque",
    "torques_at_limit",
]


class TorquePoint(NamedTuple):
    """Steady state at a demanded mean torque. If the torque jumps across it, it is a mix in time of two references.

    If the torque is out of reach, every mean is NaN.
    """

    robust: bool
    """True if the torque at the current limit reaches the demanded one."""
    static: bool
    """True if the maximum torque over all references up to the limit reaches it."""
    reference: float
    """Current reference, for a mix its mean in time (A)."""
    reference_low: float
    """Reference of the side with less torque (A)."""
    reference_high: float
    """Reference of the side with more torque (A)."""
    share: float
    """Share of time at `reference_high` (1)."""
    torque: float
    """Mean electromagnetic torque (N m)."""
    torque_lowest: float
    """Minimum torque of both sides (N m)."""
    torque_highest: float
    """Maximum torque of both sides (N m)."""
    current_sum: float
    """Mean of the sum of the phase currents' magnitudes (A)."""
    input_power: float
    """Net power from the supply, including core loss and switching (W)."""
    exchanged_power: float
    """Power exchanged with the half-sources (W)."""
    returned_power: float
    """The part of `exchanged_power` that flows back (W)."""
    copper_loss: float
    """Loss in the windings' resistance (W)."""
    device_loss: float
    """Forward drops and switching (W)."""
    core_loss: float
    """Core loss, from the supply and from the shaft (W)."""
    current_peak: float
    """Maximum magnitude of a phase current on both sides (A)."""
    certified: bool
    """True if both sides are certified periodic."""


class Optimum(NamedTuple):
    """The robustly feasible advance angle of minimum cost; all NaN if there is none."""

    advance: float
    """Advance angle (rad electrical)."""
    current_sum: float
    """Mean of the sum of the phase currents' magnitudes (A)."""
    input_power: float
    """Net power from the supply, including core loss and switching (W)."""
    reference: float
    """Current reference (A)."""


class CurrentSumCurve(NamedTuple):
    """The cost of a torque over the advance angle."""

    current_sum: NDArray[np.float64]
    """Mean of the sum of current magnitudes, shape (n,) (A); NaN if not robustly feasible."""
    input_power: NDArray[np.float64]
    """Net input power, shape (n,) (W); NaN if not robustly feasible."""
    feasible: NDArray[np.bool_]
    """True if the angle is robustly feasible, shape (n,)."""


def _mean_reference(found: ReferenceSearch) -> float:
    return found.low + found.share * (found.high - found.low)


def _mixed(low: SteadyState, high: SteadyState, share: float, name: str) -> float:
    first = float(getattr(low, name))
    return first + share * (float(getattr(high, name)) - first)


def point_at_torque(
    drive: AnyDrive, speed: float, advance: float, torque: float, voltage: float | None = None
) -> TorquePoint:
    """Return the steady state at a speed, an advance angle and a mean torque.

    `speed`: shaft speed (rad/s), above 0. `advance`: advance angle (rad electrical). `torque`: demanded mean
    electromagnetic torque (N m). `voltage`: voltage of each half-source (V); the drive's nominal one by default.
    Result: means at the minimum current reference that produces the torque. Raises InputError if speed, torque or
    voltage is not a usable number.
    """
    demand = torque_demand(drive, speed, torque, voltage)
    _, work, slices, speed, supply, torque = demand
    found = reference_for_torque(
        drive,
        work,
        slices,
        speed,
        supply,
        advance,
        torque,
        drive.current_limit,
        CURRENT_TOLERANCE,
        0.0,
        False,
    )
    if found.feasibility == OUT_OF_REACH:
        return TorquePoint(False, False, *(nan,) * 15, False)
    # The search compares means; only extremes of the torque need space for segments.
    work = make_phases(drive, KEPT_TIME)
    low = solve_steady_state(drive, work, slices, speed, supply, found.low, advance)
    high = low
    # If the torque jumps across the demanded one, the regulator alternates between both sides.
    if found.share > 0.0:
        high = solve_steady_state(drive, work, slices, speed, supply, found.high, advance)
    share = found.share
    input_power = sum(
        _mixed(low, high, share, name) for name in ("source_power", "core_source_power", "switching_loss")
    )
    return TorquePoint(
        robust=found.feasibility == ROBUST,
        static=True,
        reference=_mean_reference(found),
        reference_low=found.low,
        reference_high=found.high,
        share=share,
        torque=_mixed(low, high, share, "torque"),
        # Both sides occur in a mix, so its extremes are those of the sides, not their mean.
        torque_lowest=min(low.torque_lowest, high.torque_lowest),
        torque_highest=max(low.torque_highest, high.torque_highest),
        current_sum=_mixed(low, high, share, "current_sum"),
        input_power=input_power,
        exchanged_power=_mixed(low, high, share, "exchanged_power"),
        returned_power=_mixed(low, high, share, "returned_power"),
        copper_loss=_mixed(low, high, share, "copper_loss"),
        device_loss=_mixed(low, high, share, "device_loss"),
        core_loss=_mixed(low, high, share, "core_loss"),
        current_peak=max(low.current_peak, high.current_peak),
        certified=bool(low.certified and high.certified),
    )


def feasible_edge(
    drive: AnyDrive, speed: float, torque: float, voltage: float | None = None, static: bool = False
) -> float:
    """Return the smallest advance angle at which a torque can be produced.

    The paper's "necessary" angle (Fig. 6) is read as the robust edge, the default.

    `drive`, `speed`, `torque`, `voltage`: arguments of `point_at_torque`, with its errors. `static`: true to allow any
    current reference up to the limit, not only the limit itself. Result: the edge (rad electrical), from a scan in
    steps of 1 degree, located to 1e-4 degree. It is 0 if no advance is needed, and NaN if no angle up to 90 degrees is
    sufficient.
    """
    return smallest_feasible(torque_demand(drive, speed, torque, voltage), static)


def _least(drive: AnyDrive, speed: float, torque: float, voltage: float | None, by_power: bool) -> Optimum:
    demand = torque_demand(drive, speed, torque, voltage)
    advance = least_cost(demand, by_power)
    if isnan(advance):
        return Optimum(nan, nan, nan, nan)
    # Repeat this, because the search compared costs with a coarser tolerance.
    found = search_reference(demand, advance)
    return Optimum(advance, found.current_sum, found.input_power, _mean_reference(found))


def least_current_sum(drive: AnyDrive, speed: float, torque: float, voltage: float | None = None) -> Optimum:
    """Return the advance angle of minimum sum of current magnitudes, the objective of the paper's Fig. 4.

    The arguments and errors are those of `point_at_torque`. Result: the minimum over all robustly feasible angles from
    0 to 90 degrees: a grid of 1 degree, its two lowest valleys on a grid of 0.1 degree, then golden section to 0.001
    degree and the feasible edge. With a band the grid omits angles at which the sum with the ideal regulator is far
    larger.
    """
    return _least(drive, speed, torque, voltage, False)


def least_input_power(drive: AnyDrive, speed: float, torque: float) -> Optimum:
    """Return the advance angle of minimum net input power, with arguments, search and errors of `least_current_sum`."""
    return _least(drive, speed, torque, None, True)


def current_sum_curve(drive: AnyDrive, speed: float, torque: float, advances: ArrayLike) -> CurrentSumCurve:
    """Return the cost of a torque over the advance angle.

    `drive`, `speed`, `torque`: arguments of `point_at_torque`, with its errors. `advances`, shape (n,): advance angles
    (rad electrical).
    """
    demand = torque_demand(drive, speed, torque)
    angles = np.asarray(advances, dtype=np.float64).ravel()
    found = [search_reference(demand, float(advance)) for advance in angles]
    return CurrentSumCurve(
        np.array([point.current_sum for point in found]),
        np.array([point.input_power for point in found]),
        np.array([point.feasibility == ROBUST for point in found], dtype=np.bool_),
    )
