"""The phases whose currents change from an instant on, and the neutral's voltage with them."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.star.plant.kirchhoff import balance
from drivegate_models.star.plant.places import HELD
from drivegate_models.star.plant.staircase import Circuit, tread_voltage

TIE: Final = 2e-12
"""Distance from an interval's end that counts as zero, relative to half the link's voltage."""
_RATE_TIE = 1e-12
"""Difference of rates that counts as zero, relative to the steepest rate."""


class Neutral(NamedTuple):
    """The neutral's voltage from an instant on."""

    voltage: float
    """Voltage relative to the middle of the link (V)."""
    rate: float
    """Rate of the voltage (V/s); undefined while no phase moves."""
    moving: int
    """Number of phases whose current moves."""
    connected: int
    """Number of phases whose current moves or is not zero."""


@inlined
def _mean_of_moving(places: NDArray[Any]) -> tuple[float, int]:
    """Return the neutral's voltage determined by the moving phases (V), and their number."""
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
    """Set whether each phase at a level moves or is held; return the number of phases at an interval's end."""
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
    """Return the maximum magnitude of a back-EMF's rate (V/s)."""
    steepest = 0.0
    for k in range(places.size):
        steepest = max(steepest, abs(places[k].opposed_rate))
    return steepest


@inlined
def _release(places: NDArray[Any], bounds: NDArray[np.float64]) -> None:
    """Release the phases at their interval's end that the neutral's rate moves away from their level."""
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
        # At both ends the interval is empty, so the phase cannot be held.
        if place.at_high and (rate > own + tie or (place.at_low and rate >= own)):
            place.tread = place.below
            place.is_leaving = True
        elif place.at_low and (rate < own - tie or place.at_high):
            place.tread = place.above
            place.is_leaving = True


@inlined
def _hold_single(places: NDArray[Any]) -> None:
    """Hold a phase that is the only one to leave its level: no other phase could carry its current."""
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
    """Return the middle of the intersection of the held phases' intervals after a time (V)."""
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
    """Find the moving phases and the neutral, and set slope and curvature of every moving phase.

    `places`, shape (m,): with staircase and back-EMF of every phase; receives tread, slope and curvature. `bounds`,
    shape (2, m): work space. `currents`, shape (m,): phase currents (A).
    """
    count = places.size
    on_treads = 0
    total = 0.0
    for k in range(count):
        place = places[k]
        # The voltage falls as the current grows, so the tread above determines the lower end.
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
    # In nearly all cases the phases on treads determine the neutral, and the interval of every other phase contains it.
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
            _release(places, bounds)
            _hold_single(places)
        mean, moving = _mean_of_moving(places)
        if moving > 0:
            voltage = mean
    return _moved(circuit, places, currents, voltage)


@inlined
def _moved(circuit: Circuit, places: NDArray[Any], currents: NDArray[np.float64], voltage: float) -> Neutral:
    """Return the neutral with its rate, and set slope and curvature of every moving phase."""
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
    # They sum to zero except for the rounding of voltages, which is large compared with a small current.
    if last_free >= 0:
        places[last_free].slope -= slopes
    if last >= 0:
        places[last].curvature -= curvatures
    return Neutral(voltage, rate, moving, connected)
