"""Which phases move from an instant on, and how the neutral moves with them."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.star.plant.kirchhoff import balance
from drivegate_models.star.plant.places import HELD
from drivegate_models.star.plant.staircase import Circuit, tread_voltage

TIE: Final = 2e-12
"""Distance from an interval's end that counts as none, over half the link's voltage."""
_RATE_TIE = 1e-12
"""Difference of rates that counts as none, over the steepest."""


class Neutral(NamedTuple):
    """The neutral's voltage from an instant on."""

    voltage: float
    """Against the middle of the link (V)."""
    rate: float
    """(V/s); not defined while no phase moves."""
    moving: int
    """Number of phases that are not held."""
    connected: int
    """Number of phases that are not held without a current."""


@inlined
def _mean_of_moving(places: NDArray[Any]) -> tuple[float, int]:
    """Return the neutral's voltage that the moving phases make, and how many these are."""
    total = 0.0
    count = 0
    for k in range(places.size):
        place = places[k]
        if place.tread != HELD and not place.is_leaving:
            total += place.low if place.tread == place.above else place.high
            count += 1
    return (total / count if count > 0 else 0.0), count


@inlined
def _compare(places: NDArray[Any], voltage: float, tie: float) -> int:
    """Let every phase at a level move that the neutral pulls from it; return how many are at an interval's end."""
    ties = 0
    for k in range(places.size):
        place = places[k]
        place.at_high = False
        place.at_low = False
        place.is_leaving = False
        reached = place.reached
        place.reached = 0
        if place.below == place.above:
            place.tread = place.below
            continue
        if voltage > place.high + tie:
            place.tread = place.below
        elif voltage < place.low - tie:
            place.tread = place.above
        else:
            place.tread = HELD
            place.at_high = voltage >= place.high - tie or reached > 0
            place.at_low = voltage <= place.low + tie or reached < 0
            if place.at_high or place.at_low:
                ties += 1
    return ties


@inlined
def _steepest(places: NDArray[Any]) -> float:
    """Return the greatest magnitude of a back-EMF's rate (V/s)."""
    steepest = 0.0
    for k in range(places.size):
        steepest = max(steepest, abs(places[k].opposed_rate))
    return steepest


@inlined
def _part(places: NDArray[Any], bounds: NDArray[np.float64]) -> None:
    """Let those phases leave their level that the neutral, at their interval's end, is about to pull from it."""
    for k in range(places.size):
        place = places[k]
        rate = -place.opposed_rate
        is_free = place.tread != HELD
        bounds[0, k] = rate if is_free or place.at_low else -np.inf
        bounds[1, k] = rate if is_free or place.at_high else np.inf
    rate = balance(bounds[0], bounds[1])
    tie = _RATE_TIE * _steepest(places)
    for k in range(places.size):
        place = places[k]
        if place.tread != HELD:
            continue
        own = -place.opposed_rate
        # At both ends there is no interval to be held in.
        if place.at_high and (rate > own + tie or (place.at_low and rate >= own)):
            place.tread = place.below
            place.is_leaving = True
        elif place.at_low and (rate < own - tie or place.at_high):
            place.tread = place.above
            place.is_leaving = True


@inlined
def _stay_alone(places: NDArray[Any]) -> None:
    """Hold a phase that would leave its level alone: no other could carry its current."""
    moving = 0
    leaving = -1
    for k in range(places.size):
        if places[k].tread != HELD:
            moving += 1
            if places[k].is_leaving:
                leaving = k
    if moving == 1 and leaving >= 0:
        places[leaving].tread = HELD
        places[leaving].is_leaving = False


@inlined
def shared_middle(places: NDArray[Any], time: float) -> float:
    """Return the middle of what the intervals of held phases share after a time (V)."""
    low = -np.inf
    high = np.inf
    for k in range(places.size):
        place = places[k]
        low = max(low, place.low - place.opposed_rate * time)
        high = min(high, place.high - place.opposed_rate * time)
    return 0.5 * (low + high)


@inlined
def settle(
    circuit: Circuit, places: NDArray[Any], bounds: NDArray[np.float64], currents: NDArray[np.float64]
) -> Neutral:
    """Find which phases move and where the neutral is; give every moving phase its slope and curvature.

    Parameters
    ----------
    circuit : Circuit
        Constants.
    places : ndarray of PLACE, shape (m,)
        With staircase and back-EMF of every phase; receives tread, slope and curvature.
    bounds : ndarray, shape (2, m)
        Room for the computation.
    currents : ndarray, shape (m,)
        Phase currents (A).

    Returns
    -------
    Neutral
        Where it is.
    """
    count = places.size
    on_treads = 0
    total = 0.0
    for k in range(count):
        place = places[k]
        # The voltage falls as the current grows, so the tread above makes the lower end.
        place.low = tread_voltage(circuit, place.gate, place.above) - place.opposed
        place.high = place.low
        if place.below != place.above:
            place.high = tread_voltage(circuit, place.gate, place.below) - place.opposed
        else:
            total += place.low
            on_treads += 1
        bounds[0, k] = place.low
        bounds[1, k] = place.high
    tie = TIE * circuit.source
    # Nearly always the phases on treads decide alone, and every other one is content with that.
    voltage = total / on_treads if on_treads > 0 else 0.0
    is_settled = on_treads > 0
    for k in range(count):
        place = places[k]
        if place.below != place.above and not (
            place.low + tie < voltage < place.high - tie and place.reached == 0
        ):
            is_settled = False
    if is_settled:
        for k in range(count):
            place = places[k]
            place.at_high = False
            place.at_low = False
            place.is_leaving = False
            place.reached = 0
            place.tread = place.below if place.below == place.above else HELD
    else:
        voltage = balance(bounds[0], bounds[1])
        if _compare(places, voltage, tie) > 0:
            _part(places, bounds)
            _stay_alone(places)
        mean, moving = _mean_of_moving(places)
        if moving > 0:
            voltage = mean
    return _moved(circuit, places, currents, voltage)


@inlined
def _moved(circuit: Circuit, places: NDArray[Any], currents: NDArray[np.float64], voltage: float) -> Neutral:
    """Return the neutral and its rate; give every moving phase its slope and curvature."""
    moving = 0
    connected = 0
    total = 0.0
    for k in range(places.size):
        place = places[k]
        if place.tread != HELD:
            total -= place.opposed_rate
            moving += 1
            connected += 1
        elif currents[k] != 0.0:
            connected += 1
    rate = total / moving if moving > 0 else 0.0
    slopes = 0.0
    curvatures = 0.0
    last = -1
    last_free = -1
    for k in range(places.size):
        place = places[k]
        place.slope = 0.0
        place.curvature = 0.0
        if place.tread != HELD:
            if not place.is_leaving:
                point = place.low if place.tread == place.above else place.high
                place.slope = (point - voltage) * circuit.inverse_inductance
                slopes += place.slope
                last_free = k
            place.curvature = (place.opposed_rate + rate) * circuit.inverse_inductance
            curvatures += place.curvature
            last = k
    # They sum to zero but for the rounding of voltages, which is much beside a small current.
    if last_free >= 0:
        places[last_free].slope -= slopes
    if last >= 0:
        places[last].curvature -= curvatures
    return Neutral(voltage, rate, moving, connected)
